"""Keeping what the device measured, tick by tick, and what was true."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.device.device import N_MOTORS
from jawenv.envs.world.record import Truth
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH


class _TrueTick:
    """The truth of one tick, beside the filter's ``ROW``."""

    wrench: Annotated[Array, N_SAMPLES, N_WRENCH]  # during it
    trend: Annotated[Array, N_WRENCH]  # of the load cell, at its start
    friction_share: Annotated[Array, N_MOTORS]  # of the motors at its end, where no load cell reads the force
    state: Annotated[Array, "states"]  # the motion at its end


@cache
def true_tick_dtype(n_states: int) -> np.dtype[np.void]:
    """Dtype of ``_TrueTick``."""
    return record_dtype(_TrueTick, states=n_states)


@njit
def keep_reading(tick, measured, samples, used, ticks):
    """Round what was read to the precision of row ``tick`` of ``ticks``, and write it there while there are rows."""
    for i in range(measured.shape[0]):
        measured[i] = np.float64(np.float32(measured[i]))
    for i in range(samples.shape[0]):
        for k in range(6):
            samples[i, k] = np.float64(np.float32(samples[i, k]))
    if tick >= ticks.shape[0]:
        return
    row = ticks[tick]
    for i in range(row.measured.shape[0]):
        row.measured[i] = measured[i] if used[i] else np.nan
    row.samples[:, :] = samples


@njit
def keep_truth(truth: Truth, tick, wrench, trend, path):
    """Write what was true into row ``tick`` of ``path``, which begins anew where it has fewer rows than ticks."""
    row = path[tick % path.shape[0]]
    for i in range(row.wrench.shape[0]):
        for k in range(6):
            row.wrench[i, k] = wrench[i, k]
    row.trend[:] = trend
    row.friction_share[:] = truth.friction_share
    for i in range(row.state.shape[0]):
        row.state[i] = truth.state[i]
