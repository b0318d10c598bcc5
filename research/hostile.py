"""Hostile actions in every model, cohort and control: lost filters, and how many of them the alarm names.

Each world has its own way to act, held to the end of its episode: the 16 corners of the motors' range, constant random
commands, random recurrent networks that see the observation, and the excitations of ``agents``. An episode that
crosses a hard limit ends (``terminated``); lost is who has NEES/p beyond 10 at the end. Silent is who is
lost, whose episode did not end by a limit, and whose alarm does not ring. Prints a table in Markdown:

    python -m research.hostile --steps 2000000

Finished rows are kept in --output, so that the same command goes on.
"""

import argparse
import json
import time
from itertools import product
from pathlib import Path

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

import jawenv
from jawenv.controls import mode_of
from jawenv.playing.excitation import ACTION_SIZE, EXCITATIONS

IDS = ("JawHinge-v3", "JawSides-v3", "Jaw-v3", "JawPortions-v3", "JawBilateral-v3", "JawImaged-v3")
CONTROLS = ("targets", "force", "trajectory")
CORNERS = np.array([[1.0 - 2.0 * (i >> k & 1) for k in range(ACTION_SIZE)] for i in range(2**ACTION_SIZE)])
SECONDS, EACH, LOST = 30.0, 4, 10.0


class _Recurrent:
    """Networks with random weights, one for each world: 32 tanh units that see the observation and themselves."""

    def __init__(self, worlds, observed, rng):
        self.inputs = rng.normal(size=(worlds, 32, observed)) * 2.0 / np.sqrt(observed)
        self.own = rng.normal(size=(worlds, 32, 32)) * 1.5 / np.sqrt(32)
        self.out = rng.normal(size=(worlds, ACTION_SIZE, 32)) * 2.0 / np.sqrt(32)
        self.state = np.zeros((worlds, 32))

    def act(self, observations):
        seen = np.einsum("nij,nj->ni", self.inputs, np.clip(observations, -5.0, 5.0))
        self.state = np.tanh(seen + np.einsum("nij,nj->ni", self.own, self.state))
        return np.tanh(np.einsum("nij,nj->ni", self.out, self.state))


class _Hostile:
    """All ways to act at once."""

    def __init__(self, observed, steps_per_s, seed):
        rng = np.random.default_rng(seed)
        self.constant = np.concatenate([CORNERS, rng.uniform(-1.0, 1.0, (EACH * 4, ACTION_SIZE))])
        self.networks = _Recurrent(EACH * 4, observed, rng)
        self.excitations = [make(float(steps_per_s)) for make in EXCITATIONS.values()]
        for part in self.excitations:
            part.reset(EACH, seed=seed)
        self.worlds = len(self.constant) + EACH * 4 + EACH * len(self.excitations)

    def act(self, observations):
        first, last = len(self.constant), len(self.constant) + EACH * 4
        parts = [part.predict(observations[last:][:EACH])[0] for part in self.excitations]
        return np.concatenate([self.constant, self.networks.act(observations[first:last]), *parts]).astype(np.float32)


def episode(env_id, cohort, control, seed):
    """(steps, worlds, terminated, lost, lost without a word, largest NEES / p) of one episode of every way to act."""
    size = gym.make(f"jawenv/{env_id}").observation_space.shape[0]
    rate = mode_of({"control": control}).steps_per_s
    hostile = _Hostile(size, rate, seed)
    envs = gym.make_vec(
        f"jawenv/{env_id}",
        hostile.worlds,
        cohort=cohort,
        control=control,
        episode_s=SECONDS,
        autoreset_mode=AutoresetMode.DISABLED,
    )
    observations, _ = envs.reset(seed=seed)
    steps, ended = 0, np.zeros(hostile.worlds, dtype=bool)
    crossed = ended.copy()
    for _ in range(round(SECONDS * rate)):
        observations, rewards, terminated, truncated, info = envs.step(hostile.act(observations))
        steps += int(np.sum(~ended))
        crossed |= terminated
        ended |= terminated | truncated
        for name, values in (("observation", observations), ("reward", rewards), *info.items()):
            if isinstance(values, np.ndarray) and values.dtype.kind == "f" and not np.isfinite(values).all():
                raise SystemExit(f"{name} is no number: {env_id}, {cohort}, {control}, seed {seed}")
    nees = info["nees"] / info["belief_sd"].shape[1]
    lost = nees > LOST
    silent = lost & ~crossed & ~(info["misfit"] > 1.0)
    return (
        steps,
        hostile.worlds,
        int(crossed.sum()),
        int(lost.sum()),
        int(silent.sum()),
        float(nees[~crossed].max(initial=0.0)),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Play hostile actions and count the lost.")
    parser.add_argument("--steps", type=int, default=2_000_000)
    parser.add_argument("--seed", type=int, default=24_000)
    parser.add_argument("--output", type=Path, default=Path("runs/hostile.json"))
    arguments = parser.parse_args()
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    totals = json.loads(arguments.output.read_text()) if arguments.output.exists() else {}
    cells, start = list(product(IDS, CONTROLS, sorted(jawenv.COHORTS))), time.monotonic()
    for number, (env_id, control, cohort) in enumerate(cells):
        seed = arguments.seed
        key = f"{env_id} {control} {cohort} {arguments.steps} {seed}"
        if key in totals:
            continue
        total, due = np.zeros(6), arguments.steps / len(cells)
        while total[0] < due:
            played = np.array(episode(env_id, cohort, control, seed))
            total[:5] += played[:5]
            total[5] = max(total[5], played[5])
            seed += 1000
        totals[key] = total.tolist()
        arguments.output.write_text(json.dumps(totals))
        print(f"{number + 1} of {len(cells)} · {time.monotonic() - start:.0f} s · {key}", flush=True)
    head = ("environment", "control", "steps", "episodes", "ended by a limit", "lost", "silent", "largest NEES/p")
    print(f"| {' | '.join(head)} |")
    print("|---|---|--:|--:|--:|--:|--:|--:|")
    for env_id, control in product(IDS, CONTROLS):
        keys = [f"{env_id} {control} {cohort} {arguments.steps} {arguments.seed}" for cohort in sorted(jawenv.COHORTS)]
        rows = np.array([totals[key] for key in keys])
        steps, worlds, crossed, lost, silent = rows[:, :5].sum(axis=0)
        counts = f"{steps:,.0f} | {worlds:.0f} | {crossed / worlds:.0%} | {lost:.0f} | {silent:.0f}"
        print(f"| `{env_id}` | {control} | {counts} | {rows[:, 5].max():.1f} |")


if __name__ == "__main__":
    main()
