"""Sensors that are wrong in ways that noise is not: an offset, play, readings that are lost or frozen."""

from __future__ import annotations

import numpy as np

from jawenv.kernels.compiled import njit
from jawenv.kernels.noise import fill_normals
from jawenv.reality.options import RealityRecord
from jawenv.reality.state import RealityState


@njit
def biased(state: RealityState, samples):
    """Add the load cell's offset of this episode to each of its ``samples`` (n, 6), in place."""
    for k in range(6):
        if state.bias[k] != 0.0:
            for i in range(samples.shape[0]):
                samples[i, k] += state.bias[k]


@njit
def play(reality: RealityRecord, state: RealityState, measured):
    """Let the first six of ``measured``, place (m) and angles (rad), follow the motion with a dead band, in place.

    The play operator (Krasnosel'skii & Pokrovskii 1989): what is shown stays until it differs by half the band from
    what is, and is then dragged along. It depends on the path, not on its rate.
    """
    for k in range(6):
        band = reality.play_position if k < 3 else reality.play_angle
        if band > 0.0:
            state.play[k] = min(max(state.play[k], measured[k] - 0.5 * band), measured[k] + 0.5 * band)
            measured[k] = state.play[k]


N_CHANNELS = 18  # 12 encoders, 6 components of the load cell
FAULT_TICKS = 2**40  # the faults' random numbers are those of ticks that no episode reaches


@njit
def fail(reality: RealityRecord, state: RealityState, key, tick, measured, samples, faults):
    """Let encoders (12) and load cell (3, 6) fail, in place; ``faults`` (20) is working memory.

    Each channel has one standard normal per tick: its lower tail loses the reading, its upper tail repeats the last. A
    sensor that is frozen before its first reading shows none.
    """
    if reality.lost_below == -np.inf and reality.frozen_above == np.inf:
        return
    fill_normals(key, tick + FAULT_TICKS, faults)
    for k in range(N_CHANNELS):
        missing, frozen = faults[k] < reality.lost_below, faults[k] > reality.frozen_above
        if k < 12:
            if frozen:
                measured[k] = state.shown[k]
            state.shown[k] = measured[k]
            if missing:
                measured[k] = np.nan
        else:
            for i in range(samples.shape[0]):
                if frozen:
                    samples[i, k - 12] = state.shown[k]
                state.shown[k] = samples[i, k - 12]
                if missing:
                    samples[i, k - 12] = np.nan
