"""What it costs to know anatomy and device only within sds: processor time of 50 ms of one world, a table in Markdown.

    python tests/benchmarks/knowledge.py

``refined`` for 30 s, 32 worlds of seeds 20000 on, one thread: over the whole episode and over its last 15 s, in which
readings are not filtered again. Rows are of one run, so that their ratios hold on any machine.
"""

import time
from itertools import product

import gymnasium as gym
import numba
import numpy as np
from gymnasium.vector import AutoresetMode

import jawenv

WORLDS, SECONDS, SETTLED = 32, 30.0, 15.0
MEMORY = {"unmodelled_time_s": 0.5}


def microseconds(control, knowledge, device):
    """Of 50 ms of one world: mean over the episode, and over its last seconds."""
    envs = gym.make_vec(
        "jawenv/Jaw-v3",
        WORLDS,
        control=control,
        knowledge=knowledge,
        device=device,
        episode_s=SECONDS + 1.0,
        autoreset_mode=AutoresetMode.DISABLED,
    )
    observations, _ = envs.reset(seed=20_000)
    agent, rate = jawenv.Player("refined", control=control), envs.unwrapped.simulation.configuration.steps_per_s
    agent.reset(WORLDS, 0)
    spent = []
    for _ in range(round(SECONDS * rate)):
        actions = agent.predict(observations)[0].astype(np.float32)
        start = time.process_time()
        observations, *_ = envs.step(actions)
        spent.append(time.process_time() - start)
    scale = 1e6 * 0.05 * rate / WORLDS
    return scale * np.mean(spent), scale * np.mean(spent[-round(SETTLED * rate) :])


def main():
    numba.set_num_threads(1)
    print("| control | disturbance with memory | exact, us, 30 s / last 15 s | imaged | times |\n|---|---|--:|--:|--:|")
    for control, device in product(("targets", "force"), (None, MEMORY)):
        exact, imaged = (microseconds(control, level, device) for level in ("exact", "imaged"))
        pairs = [" / ".join(f"{value:.0f}" for value in both) for both in (exact, imaged)]
        ratio = " / ".join(f"{b / a:.1f}" for a, b in zip(exact, imaged, strict=True))
        print(f"| {control} | {'yes' if device else 'no'} | {' | '.join(pairs)} | {ratio} |", flush=True)


if __name__ == "__main__":
    main()
