"""The load cell's samples of a tick: their mean, and the trend that they follow."""

from __future__ import annotations

from math import exp

from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH

TREND_TIME = 0.05  # s: long beside a tick, short beside a maneuver
# s over which the reading is smoothed from which a tick is predicted. The noise of a sample is in the filtered motion,
# and so in the next innovation: not smoothed it biases mass and damping; over 50 ms the servo's answers lag too much.
SMOOTHING_TIME = 0.02


@njit
def mean_reading(samples, k):
    """Mean of component k over a step from its three samples, by Simpson's rule."""
    return (samples[0, k] + 4.0 * samples[1, k] + samples[2, k]) / 6.0


@njit
def mean_force(samples):
    """Mean force over a step from its three samples."""
    return mean_reading(samples, 0), mean_reading(samples, 1), mean_reading(samples, 2)


@njit
def follow_trend(trend, samples, dt, time=TREND_TIME):
    """Let the load cell's trend (6) follow its samples with a time constant; called after they have been used."""
    follow = 1.0 - exp(-dt / time)
    for k in range(N_WRENCH):
        trend[k] += follow * (mean_reading(samples, k) - trend[k])
