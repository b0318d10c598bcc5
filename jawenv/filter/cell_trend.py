"""The load cell's samples of a tick: their mean, and the trend that they follow."""

from __future__ import annotations

from math import exp

from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH

TREND_TIME = 0.05  # s: long beside a tick, short beside a maneuver


@njit
def mean_reading(samples, k):
    """Mean of component k over a step from its three samples, by Simpson's rule."""
    return (samples[0, k] + 4.0 * samples[1, k] + samples[2, k]) / 6.0


@njit
def mean_force(samples):
    """Mean force over a step from its three samples."""
    return mean_reading(samples, 0), mean_reading(samples, 1), mean_reading(samples, 2)


@njit
def follow_trend(trend, samples, dt):
    """Let the load cell's trend (6) follow its samples with ``TREND_TIME``; called after they have been used."""
    follow = 1.0 - exp(-dt / TREND_TIME)
    for k in range(N_WRENCH):
        trend[k] += follow * (mean_reading(samples, k) - trend[k])
