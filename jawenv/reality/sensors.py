"""Sensors that are wrong in ways that noise is not: a load cell's offset, encoders with play."""

from __future__ import annotations

from jawenv.kernels.compiled import njit
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
