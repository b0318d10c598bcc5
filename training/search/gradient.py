"""One maneuver for all patients, searched by the gradient of the twin.

The search of `agents.twin.search` with new patients in each update. Discomfort has a price that is learned, so that it
is within its limit on average in the environment, which has more of it than the twin.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np

import jawenv  # noqa: F401  registers its environments
from agents.twin.constants import Patients, Twin
from agents.twin.search import searched
from jawenv.base.seeds import TUNING
from jawenv.device.channels import FASTEST_TARGET, HIGHEST, LOWEST
from jawenv.ladder import DEFAULT_ENV
from jawenv.playing.agents import Array
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import action_of
from jawenv.playing.policies.following import DECISION_HZ
from training.run.callbacks import Multiplier
from training.run.config import ComfortConfig

TARGET_DISCOMFORT_S = 0.1  # in 30 s, on average
PER_30_S = 30.0
DECISION_S = 1.0 / DECISION_HZ


def search(
    refined: str,
    cohort: str,
    updates: int,
    patients: int,
    horizon_s: float,
    report: Callable[[int, float, float], None] = lambda done, worst, discomfort: None,
) -> Array:
    """Targets (T, 4) at the ends of T decisions.

    Args:
        refined: maneuver where the search begins, a name or a file.
        cohort: population of the patients.
        updates: of the targets.
        patients: new ones in each update.
        horizon_s: length of the maneuver.
        report: called with the updates done, the mean log of the largest sd and the discomfort (s in 30 s).
    """
    maneuver = Maneuver.of(refined)
    arguments: dict[str, Any] = {"cohort": cohort, "episode_s": horizon_s}
    env: Any = gym.make_vec(DEFAULT_ENV, patients, **arguments, autoreset_mode="disabled")
    env.reset(seed=TUNING.start)
    simulation = env.unwrapped.simulation
    twin = Twin(simulation)
    times = twin.decision_s * np.arange(1, round(horizon_s / twin.decision_s) + 1, dtype=np.float64)
    price = Multiplier(ComfortConfig(target_discomfort_s=TARGET_DISCOMFORT_S, initial_multiplier=2.0))

    def tried(done: int, targets: Array, worst: float) -> None:
        felt = PER_30_S / horizon_s * _discomfort_of(env, within_reach(targets[0], twin.decision_s))
        price.update(felt)
        report(done, worst, felt)
        env.reset()

    found = searched(
        twin,
        lambda: Patients.of_worlds(simulation.worlds),
        maneuver.targets(times).value[None],
        updates,
        price=lambda: price.value,
        report=tried,
    )
    env.close()
    return within_reach(found[0], twin.decision_s)


def _discomfort_of(env: Any, targets: Array) -> float:
    """Mean discomfort, s, of targets (T, 4) for the patients of an environment after its ``reset``."""
    cost = 0.0
    for target in action_of(targets):
        info = env.step(np.tile(target.astype(np.float32), (env.num_envs, 1)))[-1]
        cost += float(info["cost"].mean())
    return cost / DECISION_HZ


def within_reach(targets: Array, decision_s: float) -> Array:
    """The targets (T, 4) that a device reaches that follows these."""
    most = decision_s * np.array(FASTEST_TARGET)
    reached, place = np.clip(targets, LOWEST, HIGHEST), np.zeros(targets.shape[1])
    for i, goal in enumerate(reached):
        place = place + np.clip(goal - place, -most, most)
        reached[i] = place
    return reached
