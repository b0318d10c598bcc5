"""Records of a simulation's devices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jawenv.device.device import TICK
from jawenv.envs.simulation import Simulation
from jawenv.mechanics.dynamics import N_STATES
from jawenv.recordings.record import Record
from jawenv.recordings.resolved import unread


def record_of(simulation: Simulation, index: int) -> Record:
    """The record of world ``index``, of its present episode; the simulation must keep ticks."""
    world = simulation.worlds[index]
    rows, true = (kept[index, : world["known"]["tick"] + 1] for kept in (simulation.ticks, simulation.paths))
    return replace(
        unread(simulation.configuration, simulation.models[index]),
        time=np.arange(len(rows), dtype=np.float64) * TICK,
        measured=rows["measured"].astype(np.float64),
        samples=rows["samples"][1:].astype(np.float64),
        start_mean=world["known"]["belief"]["began"].copy(),
        start_sd=simulation.settings["filter"][0]["start_sd"][:N_STATES].copy(),
        control=simulation.configuration.control,
        truth=world["truth"]["log_parameters"].copy(),
        states=true["state"].copy(),
        wrenches=true["wrench"][1:].copy(),
    )
