"""Records of many simulated patients, by one call: the simulator of simulation-based inference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from gymnasium.utils.seeding import np_random
from numpy.typing import ArrayLike, NDArray

from jawenv.anatomy import Patient
from jawenv.base.errors import InputError, shown
from jawenv.device.device import TICK
from jawenv.envs.argument_checks import checked_actions
from jawenv.envs.configuration import Configuration
from jawenv.envs.episode_seeds import checked_seed, episode_keys
from jawenv.envs.simulation import Simulation
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.inference.settings import DEFAULT_ENV, Array, Mask, configuration_of, log_parameters, patient_of
from jawenv.inference.treatable import begins
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings.of_simulation import record_of
from jawenv.recordings.record import Record

MOST_WORLDS = 256
"""Moved together; what all of them read is in memory at the same time."""


@dataclass(frozen=True, eq=False)
class Simulations:
    """Readings of the devices of n simulated patients in T ticks of 10 ms; NaN where there is none.

    There is nothing of patients who cannot be treated, and after an episode has ended before its time. SI units, m
    states of the motion as the filter's model has them.
    """

    theta: Array
    """(n, p) natural-log parameters, as they were given."""
    time: Array
    """(T + 1,) s."""
    measured: Array
    """(n, T + 1, 12) encoders, as ``Record`` has them."""
    samples: Array
    """(n, T, 3, 6) load cell, likewise."""
    states: Array | None
    """(n, T + 1, m) true motion; None where it was not asked for."""
    wrenches: Array | None
    """(n, T, 3, 6) true wrench of the device, likewise."""
    ticks: NDArray[np.int64]
    """(n,) ticks that the episode lasted; -1 where the patient cannot be treated."""
    records: tuple[Record | None, ...]
    """N records, as every estimator takes them; None where the patient cannot be treated."""

    @property
    def treatable(self) -> Mask:
        """(n,) bool, which patients the device can treat."""
        return self.ticks >= 0


def simulate(
    theta: ArrayLike,
    actions: ArrayLike,
    seed: int = 0,
    *,
    states: bool = False,
    env_id: str = DEFAULT_ENV,
    env_kwargs: Mapping[str, Any] | None = None,
) -> Simulations:
    """Simulate the device's readings while it moves n patients by given actions.

    Row i is the episode of a single environment with ``reset(seed=seed + i, options={"patient": ...})`` and these
    actions, bit for bit, whatever the other rows are. It ends early where the environment terminates.

    Args:
        theta: (n, p) natural-log parameters, in the order of ``env.unwrapped.parameter_names``.
        actions: (K, 4) in [-1, 1] of K control periods, the same for all patients, or (n, K, 4).
        seed: of the first patient's noise, 0 or more.
        states: whether to keep the true motion and wrench, which ``jawenv.bound_along`` needs.
        env_id: an environment of jawenv.
        env_kwargs: its arguments but ``episode_s``, which follows from the actions, and ``record``.

    Raises:
        InputError: an argument has the wrong shape or a value that is not allowed.
    """
    shape = np.shape(actions)
    if len(shape) not in (2, 3) or shape[-2] < 1:
        raise InputError(f"actions has shape {shape}; allowed: (K, 4) or (n, K, 4), K 1 or more")
    configuration = _configuration(env_id, env_kwargs, shape[-2])
    rows = log_parameters(theta, 2 * len(configuration.build_cohort().muscles))
    number = checked_seed(seed)
    if number is None:
        raise InputError(f"seed is {shown(seed)}; allowed: a whole number, 0 or more")
    checked = checked_actions(actions, (*shape[:-2], shape[-2], 4))
    if len(shape) == 3 and len(checked) != len(rows):
        raise InputError(f"actions has shape {shape}; allowed with {len(rows)} patients: ({len(rows)}, K, 4)")
    repeated = np.broadcast_to(checked, (len(rows), shape[-2], 4))
    records: list[Record | None] = []
    for first in range(0, len(rows), MOST_WORLDS):
        part = slice(first, first + MOST_WORLDS)
        records += _play(configuration, rows[part], repeated[part], number + first)
    return _together(rows, records, configuration, states)


def _configuration(env_id: str, env_kwargs: Mapping[str, Any] | None, steps: int) -> Configuration:
    """Configuration of an environment that keeps what it reads, with an episode of so many control periods."""
    configuration = configuration_of(env_id, env_kwargs, {"record": True, "episode_s": 1e6})
    return replace(configuration, episode_s=steps / configuration.steps_per_s)


def _play(configuration: Configuration, theta: Array, actions: Array, seed: int) -> list[Record | None]:
    """Records of at most ``MOST_WORLDS`` patients."""
    simulation = Simulation(len(theta), configuration)
    treated = _begin(simulation, theta, seed)
    active = treated.copy()
    for step in range(actions.shape[1]):
        if not active.any():
            break
        simulation.advance(actions[:, step].copy(), active)
        truth, known = simulation.worlds["truth"], simulation.worlds["known"]
        active &= (truth["violated"] == 0) & np.isfinite(known["log_det"])
    return [record_of(simulation, i) if treated[i] else None for i in range(len(theta))]


def _begin(simulation: Simulation, theta: Array, seed: int) -> Mask:
    """Begin the episodes of all treatable patients; returns a mask (n,) of them."""
    number, muscles = len(theta), simulation.cohort.muscles.names
    patients: list[Patient | None] = [patient_of(row, muscles) for row in theta]
    generators = [np_random(seed + i)[0] for i in range(number)]
    treated = np.zeros(number, dtype=np.bool_)
    with episode_keys(generators, np.ones(number, dtype=np.bool_)) as keys:
        for i in range(number):
            treated[i] = patients[i] is not None and begins(simulation, i, patients, keys)
    return treated


def _together(theta: Array, records: list[Record | None], configuration: Configuration, states: bool) -> Simulations:
    """The records' arrays as one each, of which the records are views."""
    total = configuration.steps * configuration.ticks_per_step
    made = [record for record in records if record is not None]
    motion = len(made[0].start_mean) if made else 0
    shapes = {"measured": (total + 1, N_MEASUREMENTS), "samples": (total, N_SAMPLES, N_WRENCH)}
    if states:
        shapes |= {"states": (total + 1, motion), "wrenches": (total, N_SAMPLES, N_WRENCH)}
    arrays = {name: np.full((len(records), *shape), np.nan) for name, shape in shapes.items()}
    ticks = np.full(len(records), -1)
    views: list[Record | None] = [None] * len(records)
    for i, record in enumerate(records):
        if record is not None:
            ticks[i] = len(record.samples)
            views[i] = _as_views(record, {name: array[i] for name, array in arrays.items()})
    return Simulations(
        theta=theta,
        time=np.arange(total + 1, dtype=np.float64) * TICK,
        measured=arrays["measured"],
        samples=arrays["samples"],
        states=arrays.get("states"),
        wrenches=arrays.get("wrenches"),
        ticks=ticks,
        records=tuple(views),
    )


def _as_views(record: Record, rows: dict[str, Array]) -> Record:
    """Move a record's arrays into the beginnings of these rows; what has none is left out of the record."""
    fields: dict[str, Any] = {"states": None, "wrenches": None}
    for name, row in rows.items():
        values = getattr(record, name)
        fields[name] = row[: len(values)]
        fields[name][:] = values
    return replace(record, **fields)
