"""Keeping what the device measured, tick by tick."""

from __future__ import annotations

import numpy as np

from jawenv.envs.plants import true_state
from jawenv.kernels.compiled import njit


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
