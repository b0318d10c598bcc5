"""Speeds of environments over that of Gymnasium's Humanoid-v5, in steps of 20 Hz.

Of whole episodes: reset and all steps, in one time. Replays fall into few steps, so that a stretch may have none. Both
are processor time on one thread: by the clock a ratio measures what else the machine does.
"""

import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import gymnasium as gym
import numba
import numpy as np

from agents import load_agent
from jawenv.device.device import TICK
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.playing.agents import Agent
from jawenv.playing.rollout import DEFAULT_ENV

WORLDS = 256
CONTROL_HZ = 20.0
COMPARED = (DEFAULT_ENV, "jawenv/JawPortions-v3")
CONTROLS = ("force", "trajectory", "targets")
OTHERS = [env_id for env_id in ENVIRONMENTS if env_id != DEFAULT_ENV]
LEAST = {"gentle sines": 4.1, "strong sines": 2.1, "random actions": 2.5}
"""What 256 worlds in force control are to reach, over Humanoid-v5."""
PLANTS_IN_PYTHON = ("jawenv/JawSagittal-v3",)


class Size(NamedTuple):
    repeats: int = 7
    single_steps: int = 3_000  # five episodes
    episode_s: float = 30.0
    episodes: int = 3  # of every batch
    memory_env_steps: int = 1_000_000
    memory_single_steps: int = 20_000


class Row(NamedTuple):
    what: str
    value: str
    target: str = ""
    met: bool | None = None  # None where there is nothing to reach


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def sinusoids(worlds: int | None, strength: float = 0.3) -> Callable[[int], np.ndarray]:
    """Slow motor commands, by default of a third of full scale: four motors, each world in another phase."""
    phase = 0.7 * np.arange(4 * (worlds or 1)).reshape((4,) if worlds is None else (worlds, 4))
    return lambda step: (strength * np.sin(2.0 * np.pi * 0.3 * step / CONTROL_HZ + phase)).astype(np.float32)


# Both: steps per second, resets included.
def run_single(env: gym.Env, action: Callable[[int], np.ndarray], steps: int) -> float:
    start = time.process_time()
    for step in range(steps):
        _, _, terminated, truncated, _ = env.step(action(step))
        if terminated or truncated:
            env.reset()
    return steps / (time.process_time() - start)


def run_vector(vec: gym.vector.VectorEnv, action: Callable[[int], np.ndarray], steps: int) -> float:
    start = time.process_time()
    for step in range(steps):
        vec.step(action(step))
    return steps * vec.num_envs / (time.process_time() - start)


def agents_of(control: str) -> dict[str, Agent]:
    """What drives the worlds: slow commands that press on stops and teeth, a maneuver, and random actions."""
    sines = {"gentle sines": Sinusoids(), "strong sines": Sinusoids(0.9)}
    maneuver = load_agent("opening_with_swings_and_fore_aft", control=control)
    return sines | {"maneuver": maneuver, "random actions": load_agent("random", control=control)}


def run_driven(vec: gym.vector.VectorEnv, agent: Agent, steps: int, seed: int) -> float:
    """Env-steps per second of an episode, its reset included, without the agent's own time."""
    agent.reset(vec.num_envs, seed)
    start = time.process_time()
    observation, _ = vec.reset(seed=seed)
    busy = time.process_time() - start
    for _ in range(steps):
        action, _ = agent.predict(observation)
        start = time.process_time()
        observation = vec.step(action)[0]
        busy += time.process_time() - start
    return steps * vec.num_envs / busy


def humanoid() -> Callable[[int], float]:
    """Speed of Humanoid-v5 under random actions over so many steps."""
    env = gym.make("Humanoid-v5")
    env.reset(seed=0)
    env.action_space.seed(0)
    return lambda steps: run_single(env, lambda _: env.action_space.sample(), steps)


def paired(
    size: Size, turns: int, reference: Callable[[int], float], run: Callable[[int], float]
) -> tuple[float, float, float]:
    """Medians of the reference's speed, of ``run``'s and of their ratio, in turns, of which ``run`` gets the number."""
    table = np.array([(reference(size.single_steps), run(turn)) for turn in range(turns)])
    return float(np.median(table[:, 0])), float(np.median(table[:, 1])), float(np.median(table[:, 1] / table[:, 0]))


def speeds(size: Size) -> list[Row]:
    """One environment, and batches of three models in all control modes under three kinds of actions."""
    numba.set_num_threads(1)
    say("speed: one environment")
    jaw, reference = gym.make(DEFAULT_ENV, control="force"), humanoid()
    jaw.reset(seed=0)

    def alone(_: int) -> float:
        jaw.reset()
        return run_single(jaw, sinusoids(None), size.single_steps)

    theirs, rate, ratio = paired(size, size.repeats, reference, alone)
    rows = [
        Row("Humanoid-v5, one environment, random actions", f"{theirs:,.0f} steps/s"),
        Row("Jaw-v3, one environment, force, filter included", f"{rate:,.0f} steps/s"),
        Row("  over Humanoid-v5, median of paired ratios", f"{ratio:.2f} x", ">= 2.3 x", bool(ratio >= 2.3)),
    ]
    for env_id in COMPARED:
        for control in CONTROLS if env_id == DEFAULT_ENV else CONTROLS[-1:]:
            rows += batch_speeds(size, reference, env_id, control)
    return rows


def batch_speeds(size: Size, reference: Callable[[int], float], env_id: str, control: str) -> list[Row]:
    """256 worlds in one control mode. A step of targets control is counted as the steps of 20 Hz that it lasts."""
    vec: Any = gym.make_vec(env_id, num_envs=WORLDS, control=control)
    per_step = vec.configuration.ticks_per_step * TICK * CONTROL_HZ
    steps = int(size.episode_s * CONTROL_HZ / per_step)
    vec.reset(seed=0)
    vec.step(vec.action_space.sample())  # compiled, or read
    model, rows = env_id.partition("/")[2], []
    for name, agent in agents_of(control).items():
        say(f"speed: {model}, {control}, {name}")
        _, rate, ratio = paired(
            size,
            size.episodes,
            reference,
            lambda turn, agent=agent: per_step * run_driven(vec, agent, steps, turn),  # type: ignore[misc]
        )
        least = LEAST.get(name) if env_id == DEFAULT_ENV and control == "force" else None
        unit = "env-steps/s" if control != "targets" else "env-steps/s of 20 Hz"
        rows += [
            Row(f"{model}, {WORLDS} worlds, {control}, {name}", f"{rate:,.0f} {unit}"),
            Row(
                "  over Humanoid-v5, median of paired ratios",
                f"{ratio:.2f} x",
                "" if least is None else f">= {least} x",
                None if least is None else bool(ratio >= least),
            ),
        ]
    return rows


class Sinusoids:
    """The motor commands of the other measurements, as an agent."""

    name, control = "sinusoids", "force"

    def __init__(self, strength: float = 0.3) -> None:
        self.strength = strength

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        self.step, self.action = 0, sinusoids(num_envs, self.strength)

    def predict(self, observation: np.ndarray, **_: object) -> tuple[np.ndarray, None]:
        self.step += 1
        return self.action(self.step), None


def ladder_speeds(size: Size) -> list[Row]:
    """Speed of the other environments, alone and in a batch; pymunk's is stepped from Python, a tenth as often."""
    rows = []
    for env_id in OTHERS:
        say(f"speed: {env_id}")
        alone, vec = gym.make(env_id, control="force"), gym.make_vec(env_id, num_envs=WORLDS, control="force")
        alone.reset(seed=0)
        vec.reset(seed=0)
        share = 10 if env_id in PLANTS_IN_PYTHON else 1
        run_single(alone, sinusoids(None), 20)
        run_vector(vec, sinusoids(WORLDS), 2)
        one = run_single(alone, sinusoids(None), max(size.single_steps // share, 50))
        many = run_vector(vec, sinusoids(WORLDS), max(60 // share, 2))
        rows += [
            Row(f"{env_id.partition('/')[2]}, one environment", f"{one:,.0f} steps/s"),
            Row(f"{env_id.partition('/')[2]}, {WORLDS} worlds", f"{many:,.0f} env-steps/s"),
        ]
    return rows
