"""What the devices of a simulation have measured, as records."""

from __future__ import annotations

import numpy as np

from jawenv.envs.simulation import Simulation
from jawenv.laboratory.recordings.record import Record
from jawenv.mechanics.dynamics import N_WRENCH


def record_of(simulation: Simulation, index: int) -> Record:
    """What the device of world ``index`` has measured in its present episode; the simulation must keep ticks."""
    world, settings = simulation.worlds[index], simulation.settings["filter"][0]
    noise_variance = simulation.settings["noise_variance"][0]
    count = int(world["known"]["tick"]) + 1
    rows, true = simulation.ticks[index, :count], simulation.paths[index, :count]
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
        truth=world["truth"]["log_parameters"].copy(),
        states=true["state"].copy(),
        wrenches=true["wrench"][1:].copy(),
    )
