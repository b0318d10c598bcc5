"""When the alarm rings: in honest episodes of 30 s, and after 10 s under effects that the filter is not told.

Prints two tables in Markdown (mean NEES over the number of parameters, its largest, share of episodes with
``info["misfit"]`` above 1); takes about ten minutes:

    python tests/benchmarks/alarm.py --patients 128 --seed 20000
"""

import argparse
from itertools import product

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

import jawenv  # noqa: F401 - registers the environments
from jawenv.playing.maneuvers import Player, maneuver_names

HONEST = ("refined", "slow_opening", "hold_still", "uniform", "ou", "corners")
UNTOLD = (
    {"fossa_error": 0.1},
    {"cell_bias_N": 0.1, "cell_bias_N_m": 0.002},
    {"attachment_error": 0.1},
    {"attachment_error": 1.0},
    {"creep_share": 0.2},
    {"creep_share": 0.55},
    {"reflex_gain": 0.5},
    {"encoder_play_mm": 0.3},
    {"articular_stiffness_N_m": 2000.0},
)


class Actions:
    """A maneuver, uniform random actions, Ornstein-Uhlenbeck ones, or one corner of the range for each patient."""

    def __init__(self, name, control, patients):
        self.name, self.rng, self.x = name, np.random.default_rng(0), np.zeros((patients, 4))
        self.corners = np.array([[1.0 - 2.0 * (i >> k & 1) for k in range(4)] for i in range(patients)])
        self.player = Player(name, control=control) if name in maneuver_names() else None
        if self.player is not None:
            self.player.reset(patients, 0)

    def of(self, observations):
        if self.player is not None:
            return self.player.predict(observations)[0]
        if self.name == "uniform":
            return self.rng.uniform(-1.0, 1.0, self.x.shape)
        if self.name == "corners":
            return self.corners
        self.x = 0.9 * self.x + 0.3 * self.rng.normal(size=self.x.shape)
        return np.clip(self.x, -1.0, 1.0)


def row(name, control, seconds, given, reality=None):
    """Mean NEES / p, largest, share beyond 10, share that rings."""
    envs = gym.make_vec(
        "jawenv/Jaw-v2",
        given.patients,
        control=control,
        episode_s=seconds + 1.0,
        reality=reality,
        autoreset_mode=AutoresetMode.DISABLED,
    )
    observations, info = envs.reset(seed=given.seed)
    actions = Actions(name, control, given.patients)
    for _ in range(round(seconds * envs.unwrapped.simulation.configuration.steps_per_s)):
        observations, _, _, _, info = envs.step(actions.of(observations).astype(np.float32))
    nees = info["nees"] / info["belief_sd"].shape[1]
    rings = 100.0 * np.mean(info["misfit"] > 1.0)
    return f"{nees.mean():.2f} | {nees.max():.1f} | {np.sum(nees > 10.0)} | {rings:.0f} %"


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure when the alarm rings.")
    parser.add_argument("--patients", type=int, default=128)
    parser.add_argument("--seed", type=int, default=20_000)
    given = parser.parse_args()
    head = "NEES/12 | largest | beyond 10 | rings |\n|---|---|--:|--:|--:|--:|"
    print(f"| control | actions | {head}")
    for control, name in product(("targets", "force", "trajectory"), HONEST):
        print(f"| {control} | {name} | {row(name, control, 30.0, given)} |", flush=True)
    print(f"\n| not told | maneuver | {head}")
    for reality, name in product(UNTOLD, ("refined", "slow_opening")):
        said = ", ".join(f"`{field}={value:g}`" for field, value in reality.items())
        print(f"| {said} | {name} | {row(name, 'targets', 10.0, given, reality)} |", flush=True)


if __name__ == "__main__":
    main()
