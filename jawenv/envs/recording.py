"""Keeping what the device measured, tick by tick, and giving it back as records."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jawenv.compiled import njit
from jawenv.envs.plants import true_state
from jawenv.estimation.recordings.record import Record
from jawenv.mechanics.dynamics import N_WRENCH

if TYPE_CHECKING:
    from jawenv.envs.simulation import Simulation


@njit
def keep_tick(model, world, settings, scratch, ticks):
    """Write the tick that has just ended into row ``world.tick`` of ``ticks``, as long as there are rows.

    What is true is kept only where episodes are recorded.
    """
    if world.tick >= ticks.shape[0]:
        return
    row = ticks[world.tick]
    for i in range(row.measured.shape[0]):
        row.measured[i] = scratch.measured[i] if settings.filter.used[i] else np.nan
    for i in range(row.samples.shape[0]):
        for k in range(6):
            row.samples[i, k] = scratch.samples[i, k]
    if not settings.record:
        return
    for i in range(row.wrench.shape[0]):
        for k in range(6):
            row.wrench[i, k] = scratch.wrench[i, k]
    for i in range(row.state.shape[0]):
        row.state[i] = true_state(model, world, i)


def record_of(simulation: Simulation, index: int) -> Record:
    """What the device of world ``index`` has measured in its present episode; the simulation must keep ticks."""
    world, ticks, settings = simulation.worlds[index], simulation.ticks[index], simulation.settings["filter"][0]
    noise_variance = simulation.settings["noise_variance"][0]
    rows = ticks[: int(world["tick"]) + 1]
    return Record(
        time=np.arange(len(rows), dtype=np.float64) * simulation.tick_s,
        measured=rows["measured"].copy(),
        samples=rows["samples"][1:].copy(),
        start_mean=rows["believed"][0].copy(),
        start_sd=settings["start_sd"].copy(),
        measurement_sd=np.sqrt(settings["measurement_variance"]),
        wrench_sd=np.sqrt(noise_variance[:N_WRENCH]),
        cell_sd=np.sqrt(noise_variance[N_WRENCH:]),
        gain_sd=float(simulation.device[0]["cell_gain"]),
        jaw=simulation.models[index].copy(),
        prior=simulation.cohort.prior,
        parameter_names=simulation.cohort.muscles.parameter_names,
        device=simulation.configuration.build_device(),
        control=simulation.configuration.control,
        truth=world["log_parameters"].copy(),
        states=rows["state"].copy(),
        wrenches=rows["wrench"][1:].copy(),
    )
