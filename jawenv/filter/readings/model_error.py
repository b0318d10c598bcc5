"""Errors of the model that last as long as the jaw stays where it is, and return when it returns."""

from __future__ import annotations

from math import floor, hypot, sqrt

import numpy as np

from jawenv.filter.belief.state import Belief, FilterSettings
from jawenv.kernels.compiled import njit
from jawenv.mechanics.jaw import Jaw

# What the model has wrong at a pose it has wrong within so many m; the ticks that this takes are counted from so many
# m/s on, and up to so many. The moment's error is the force's at so many m.
ALIKE, SLOWEST, MOST_TICKS, ERROR_ARM = 1e-3, 1e-3, 100.0, 0.03
DRIFT_S, SLOWEST_DRIFT = 1.0, 3e-5  # s, m/s


@njit
def dwell_ticks(jaw: Jaw, belief: Belief, dt):
    """Ticks that the mouthpiece takes for ``ALIKE`` at its velocity, smoothed over ``DRIFT_S``."""
    shift, turn, rates = 0.0, 0.0, belief.dwell.drift_rates
    for i in range(5):
        rates[i] += dt / DRIFT_S * (belief.motion[5 + i] - rates[i])
        if i < 2:
            shift = hypot(shift, rates[i])
        else:
            turn = hypot(turn, rates[i])
    return ALIKE / (dt * max(shift + jaw.mouthpiece[0] * turn, SLOWEST_DRIFT))


@njit
def cell_of(jaw: Jaw, motion, n_cells):
    """The cell of poses, ``ALIKE`` wide at the mouthpiece in each coordinate, as a number below ``n_cells``.

    Poses far apart may share a number (a hash after Fowler, Noll and Vo): then what was learnt at the one makes the
    other count for less. Any number, NaN too, has a cell.
    """
    number = np.uint64(14695981039346656037)
    for i in range(5):
        at = motion[i] * (jaw.mouthpiece[0] if i >= 2 else 1.0)
        number = (number ^ np.uint64(np.int64(floor(at / ALIKE + 0.5)))) * np.uint64(1099511628211)
    return np.int64((number >> np.uint64(20)) % np.uint64(n_cells))


@njit
def count_ticks(jaw: Jaw, belief: Belief, settings: FilterSettings):
    """Ticks that the jaw takes for this visit to its pose, or has been there in all, whichever is more; counts this.

    Where the first ones count in full, how many it has been there beyond these, smoothed over ``DRIFT_S``. Else a jaw
    held at the edge of a cell would learn most from readings whose noise takes it to the next one, with a bias.
    """
    dwell = belief.dwell
    cell = cell_of(jaw, belief.motion, dwell.visits.shape[0])
    dwell.visits[cell] += 1.0
    dwell.visited += settings.dt / DRIFT_S * (dwell.visits[cell] - dwell.visited)
    if settings.full_weight_ticks > 0.0:
        return max(dwell.visited - settings.full_weight_ticks, 0.0)
    return max(dwell_ticks(jaw, belief, settings.dt), dwell.visits[cell])


@njit
def speed_of(jaw: Jaw, motion):
    """The mouthpiece's, m/s, as turning and sliding fore-aft add up at most."""
    turn = abs(motion[7]) + abs(motion[8]) + abs(motion[9])
    return abs(motion[5]) + jaw.mouthpiece[0] * turn


@njit
def _carried_force(jaw: Jaw, belief: Belief):
    """Sum of the device's and gravity's pull at the jaw, N."""
    trend = belief.trend
    return sqrt(trend[0] * trend[0] + trend[1] * trend[1] + trend[2] * trend[2]) + jaw.mass * -jaw.gravity[2]


@njit
def reading_weight(jaw: Jaw, belief: Belief, settings: FilterSettings):
    """Weight of a tick's readings as information.

    What is wrong in the model is so large a share of the force that is carried, and alike within ``ALIKE``. n ticks
    there with white noise of variance r tell n / (r + n s) of the force, with s the error's variance, in place of n /
    r. So each counts for r / (r + n s): a jaw that stays where it is learns no more than 1 / s. One that comes back
    finds the same error, so n counts all its visits. As more noise of the motion it would make the motion follow the
    encoders' noise, which biases what is learnt.
    """
    ticks = count_ticks(jaw, belief, settings)
    if ticks == 0.0:
        return 1.0
    noise = 0.0
    for k in range(3):
        noise += settings.wrench_variance[k] / 3.0
        if settings.disturbance_variance.shape[0] > 0:
            noise += settings.disturbance_variance[k] / (1.0 - settings.disturbance_decay**2) / 3.0
    error = settings.systematic_error * _carried_force(jaw, belief)
    return noise / (noise + ticks * error * error)


@njit
def add_model_error(jaw: Jaw, belief: Belief, settings: FilterSettings, variance):
    """Add to the process noise ``variance`` (6) what the model may have wrong at a pose while the jaw is there.

    An error of so large a share of the force that is carried, alike within ``ALIKE``, is as much noise per tick as the
    ticks that the jaw takes for that way: a maneuver that stays where it is learns no more than it sees.
    """
    ticks = min(ALIKE / (settings.dt * max(speed_of(jaw, belief.motion), SLOWEST)), MOST_TICKS)
    error = settings.model_error * _carried_force(jaw, belief)
    for k in range(3):
        variance[k] += ticks * error * error
        variance[3 + k] += ticks * error * error * ERROR_ARM * ERROR_ARM
