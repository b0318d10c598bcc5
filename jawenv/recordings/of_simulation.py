"""Records of a simulation's devices."""

from __future__ import annotations

import numpy as np

from jawenv.device.device import TICK
from jawenv.envs.simulation import Simulation
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings.defaults import disturbance_sd
from jawenv.recordings.record import Record


def record_of(simulation: Simulation, index: int) -> Record:
    """The record of world ``index``, of its present episode; the simulation must keep ticks."""
    world, settings = simulation.worlds[index], simulation.settings["filter"][0]
    noise_variance = simulation.settings["noise_variance"][0]
    cell_sd = np.sqrt(noise_variance[N_WRENCH:])
    device = simulation.configuration.build_device()
    time = device.unmodelled_time_s
    count = int(world["known"]["tick"]) + 1
    began = world["known"]["belief"]["began"]
    rows, true = simulation.ticks[index, :count], simulation.paths[index, :count]
    return Record(
        time=np.arange(len(rows), dtype=np.float64) * TICK,
        measured=rows["measured"].astype(np.float64),
        samples=rows["samples"][1:].astype(np.float64),
        start_mean=began.copy(),
        start_sd=settings["start_sd"][: len(began)].copy(),
        measurement_sd=np.sqrt(settings["measurement_variance"]),
        # Of a disturbance with memory both are the load cell's noise, and differ by rounding.
        wrench_sd=np.maximum(np.sqrt(noise_variance[:N_WRENCH]), cell_sd),
        cell_sd=cell_sd,
        gain_sd=float(simulation.device[0]["cell_gain"]),
        jaw=simulation.models[index].copy(),
        prior=simulation.cohort.prior,
        parameter_names=simulation.cohort.muscles.parameter_names,
        knowledge=simulation.knowledge,
        disturbance_time_s=time,
        disturbance_sd=disturbance_sd(device) if time > 0.0 else np.zeros(N_WRENCH),
        force_sensor=simulation.configuration.force_sensor,
        device=device,
        control=simulation.configuration.control,
        truth=world["truth"]["log_parameters"].copy(),
        states=true["state"].copy(),
        wrenches=true["wrench"][1:].copy(),
    )
