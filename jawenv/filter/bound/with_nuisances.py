"""Nuisances in the bound's recursion, true ones in the place of believed ones (``nuisances.changes``).

A nuisance moves the motion through its wrench at the mouthpiece half way through the tick, and changes what the
encoders read.
"""

from __future__ import annotations

from jawenv.filter.model.motion_step import N_NOISE
from jawenv.filter.model.regressors import middle_of
from jawenv.filter.nuisances.changes import Midway, add_readings, middle_rates, set_wrenches
from jawenv.filter.readings.cell_trend import mean_reading
from jawenv.mechanics.dynamics import N_WRENCH


def move_by_nuisances(jaw, muscles, tick, settings, scratch):
    """The effect of one sd of each nuisance on the motion at the tick's end, into its columns of the derivative."""
    before, after, wrench, friction = tick
    scratch.nuisances.friction_share[:] = friction
    pose, _ = middle_of(jaw, before, after)
    u, rate = middle_rates(before, after, settings.dt)
    mean = (
        mean_reading(wrench, 0),
        mean_reading(wrench, 1),
        mean_reading(wrench, 2),
        mean_reading(wrench, 3),
        mean_reading(wrench, 4),
        mean_reading(wrench, 5),
    )
    at = Midway(pose, u, rate, mean, False)
    set_wrenches(jaw, muscles, at, settings.nuisances, 0, scratch.wrench, scratch.nuisances)
    total, by_wrench = scratch.recursion.total, scratch.joint.total
    first, column = total.shape[0], by_wrench.shape[1] - N_NOISE
    for i in range(by_wrench.shape[0]):
        for k in range(N_WRENCH):
            for j in range(scratch.wrench.shape[1]):
                total[i, first + j] += by_wrench[i, column + k] * scratch.wrench[k, j]


def read_by_nuisances(jaw, motion, used, settings, scratch):
    """The effect of one sd of each nuisance on the readings, into its columns of their derivative."""
    first = scratch.recursion.total.shape[0]
    add_readings(jaw, motion, settings.nuisances, used, first, scratch.recursion.rows, scratch.nuisances)
