"""Which readings the filter uses: one that is missing, out of range, or repeats the last to the bit, is left out.

Encoders and load cell have noise, so that no two readings are the same number: a repetition is a sensor that has
frozen. Only a load cell without noise may repeat itself, as when no motor pushes; encoders without noise do where
nothing at all moves the jaw. No jaw leaves the range. Leaving out a reading loses its information and adds no bias.

A stop, a brake or teeth that act within a tick change its force by more than three samples resolve. The motion follows
the encoders then, and nothing is learnt of the muscles: where a linkage rattles for seconds, the same small error comes
back in every tick, and adds up to a belief that is far too sure.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.kernels.compiled import njit

# Without usable samples the wrench is held; the sd of its change grows at this rate, up to the limit of the motors.
FORCE_RATE, LOST_FORCE = 50.0, 3.0
MOMENT_RATE, LOST_MOMENT = 1.5, 0.1

# N by which a component of the force changes within 10 ms, or bends, that three samples do not resolve; and in sds of
# the load cell's mean over a tick, of which noise alone bends the samples by 12 ** 0.5.
ROUGH, ROUGH_SDS, ROUGH_TICK = 1.0, 17.0, 0.01
SETTLING = 5  # ticks after one in which the motion still follows

# Ranges: mouthpiece position (m), angles (rad), velocity (m/s), angular velocity (rad/s), force (N), moment (N m).
POSITION, ANGLE, VELOCITY, RATE = 0.5, 3.2, 5.0, 100.0
FORCE, MOMENT = 200.0, 20.0


def rough_change(cell_sd: NDArray[np.float64], dt: float) -> NDArray[np.float64]:
    """(3,) N by which a component of the force may change within a tick of ``dt`` s that is resolved.

    ``cell_sd`` (6,) are the load cell's sds of a tick's mean. In a longer tick the same motion changes it by more.
    """
    change: NDArray[np.float64] = np.maximum(ROUGH * max(1.0, dt / ROUGH_TICK), ROUGH_SDS * cell_sd[:3])
    return change


@njit
def in_range(value, largest):
    """Whether ``value`` is a number of at most this magnitude."""
    return abs(value) <= largest


@njit
def mark_usable(measured, last, allowed, used):
    """Set ``used`` (12) where ``allowed`` readings are in range and have changed; ``last`` becomes ``measured``.

    Returns how many allowed readings are left out.
    """
    left_out = 0
    ranges = (POSITION, ANGLE, VELOCITY, RATE)
    for i in range(measured.shape[0]):
        good = in_range(measured[i], ranges[i // 3]) and measured[i] != last[i]
        used[i] = 1 if allowed[i] and good else 0
        if allowed[i] and not good:
            left_out += 1
        last[i] = measured[i]
    return left_out


@njit
def repair_samples(belief, samples, settings, variance, usable):
    """Copy ``samples`` (3, 6) to ``usable``; a missing or frozen component keeps its last usable value.

    Args:
        belief: State of the filter: last samples, last usable samples, time since then.
        samples: The load cell's in a tick.
        settings: ``dt``, length of the tick (s), and ``cell_repeats`` (6), which components may repeat themselves.
        variance: (6,) process noise; grows with the time that a component is held.
        usable: (3, 6), overwritten.

    Returns:
        How many components are held.
    """
    last, held_sample, lost_for = belief.last_sample, belief.held_sample, belief.lost_for
    number = 0
    for k in range(samples.shape[1]):
        good, previous = True, last[k]
        for i in range(samples.shape[0]):
            changed = samples[i, k] != previous or settings.cell_repeats[k] != 0
            good = good and changed and in_range(samples[i, k], FORCE if k < 3 else MOMENT)
            previous = samples[i, k]
        last[k] = previous
        if good:
            held_sample[k], lost_for[k] = previous, 0.0
        else:
            lost_for[k] += settings.dt
            sd = min(FORCE_RATE * lost_for[k], LOST_FORCE) if k < 3 else min(MOMENT_RATE * lost_for[k], LOST_MOMENT)
            variance[k] += sd * sd
            number += 1
        for i in range(samples.shape[0]):
            usable[i, k] = samples[i, k] if good else held_sample[k]
    return number


@njit
def is_resolved(belief, samples, rough):
    """Whether a tick's ``samples`` (3, 6) of the load cell resolve it, and those before; called once for each tick.

    ``rough`` (3,) is as ``rough_change`` has it.
    """
    if belief.waits > 0:
        belief.waits -= 1
    for k in range(3):
        first, middle, last = samples[0, k], samples[1, k], samples[2, k]
        if abs(last - first) > rough[k] or abs(last - 2.0 * middle + first) > rough[k]:
            belief.waits = SETTLING + 1
    return belief.waits == 0
