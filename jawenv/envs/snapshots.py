"""The state of worlds in mid-episode, kept apart from the environment, so that a planner can go back to it."""

from __future__ import annotations

import copy
from dataclasses import dataclass, fields
from typing import Any

from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.envs.simulation import Simulation


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The full state of an environment, which decides its future; ``env.snapshot()`` makes it, nothing changes it."""

    kind: tuple[Any, ...]  # what the environment is: only an environment of the same is restored from it
    arrays: tuple[NDArray[Any], ...]  # worlds, the filter's jaws, readings, truths and observation
    plants: Any  # those that Python moves; None where none does
    estimators: Any  # state of the user's estimators; None without
    attributes: dict[str, Any]  # the environment's own, by name


def take_snapshot(env: Any, names: tuple[str, ...]) -> Snapshot:
    """The state of an environment's simulation, and of its attributes with these names."""
    simulation = env.simulation
    arrays = tuple(array.copy() for array in _arrays(simulation))
    attributes = copy.deepcopy({name: getattr(env, name) for name in names})
    own = simulation.own_estimators
    estimators = None if own is None else own.state()
    return Snapshot(_kind(env), arrays, copy.deepcopy(_plants(simulation)), estimators, attributes)


def restore_snapshot(env: Any, snapshot: Any) -> None:
    """Bring an environment into the state of a snapshot."""
    if not isinstance(snapshot, Snapshot):
        raise InputError(f"snapshot is a {type(snapshot).__name__}; allowed: what snapshot() has returned")
    if snapshot.kind != _kind(env):
        raise InputError("snapshot is of an environment that was made otherwise; allowed: one with the same arguments")
    simulation = env.simulation
    for array, values in zip(_arrays(simulation), snapshot.arrays, strict=True):
        array[...] = values
    if simulation.moved is not None:
        simulation.moved.each = copy.deepcopy(snapshot.plants)
    if snapshot.estimators is not None:
        simulation.own_estimators.set_state(snapshot.estimators)
    vars(env).update(copy.deepcopy(snapshot.attributes))


def _arrays(simulation: Simulation) -> tuple[NDArray[Any], ...]:
    """All that an episode depends on, but for plants that Python moves."""
    of_worlds = simulation.worlds, simulation.models, simulation.keys
    episode = simulation.asked, simulation.cost_so_far
    return *of_worlds, *episode, simulation.ticks, simulation.paths, simulation.observation


def _plants(simulation: Simulation) -> Any:
    """The plants that Python moves, or None."""
    return None if simulation.moved is None else simulation.moved.each


def _kind(env: Any) -> tuple[Any, ...]:
    """The kind of an environment, which a snapshot must share: form, number of worlds and arguments."""
    configuration, cohort = env.configuration, env.simulation.cohort
    arguments = tuple(
        getattr(configuration, argument.name)
        for argument in fields(configuration)
        if argument.name not in ("cohort", "estimator", "plant")
    )
    # Copies of one object need not be equal.
    own = configuration.own_estimator
    estimator = configuration.estimator if own is None else type(own)
    plant = configuration.plant if isinstance(configuration.plant, str | None) else type(configuration.plant)
    vector = getattr(env, "num_envs", None), getattr(env, "autoreset_mode", None), getattr(env, "_last_tick", None)
    return type(env), vector, cohort.name, cohort.groups, estimator, plant, arguments
