"""The search of the twin from a suggested movement on, for patients whom the belief allows."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np

from jawenv.anatomy import Patient
from jawenv.base.extras import of_the_clone
from jawenv.ladder import DEFAULT_ENV
from jawenv.playing.agents import Array
from jawenv.playing.maneuvers.maneuver import action_of, goals_of


def searched_actions(
    actions: Array,
    patients: list[Patient],
    seeds: list[int],
    mean: Array,
    precision: Array,
    world: dict[str, Any],
    updates: int,
    announce: Callable[[str], None] = lambda text: None,
) -> Array:
    """Actions (N, T, 4) of N movements after the search.

    Args:
        actions: (N, T, 4) that it begins with.
        patients: N groups of equal size, of whom each movement is made; those of a group side by side.
        seeds: one for each patient.
        mean: (N, 12) parameters that the recordings believe in.
        precision: (N, 12, 12) of the same, with the prior's.
        world: arguments of the environment.
        updates: steps of the search.
        announce: called after each of them, in words.

    Raises:
        MissingPackageError: torch, or the clone's package of agents, is not installed.
    """
    search, constants = (of_the_clone("--search", f"agents.twin.{part}", "train") for part in ("search", "constants"))
    env: Any = gym.make_vec(DEFAULT_ENV, len(patients), **world, autoreset_mode="disabled")
    env.reset(seed=seeds, options={"patients": patients})
    simulation = env.unwrapped.simulation
    treated = constants.Patients.of_worlds(simulation.worlds)
    twin, beliefs = constants.Twin(simulation), (mean, precision)

    def report(done: int, *_: object) -> None:
        announce(f"searched, update {done} of {updates}")

    asked = np.asarray(simulation.asked)
    found = search.searched(twin, treated, goals_of(actions), updates, asked=asked, beliefs=beliefs, report=report)
    env.close()
    return np.asarray(action_of(found), dtype=np.float32)
