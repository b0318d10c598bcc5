"""Which readings a filter may believe: one that is missing, or repeats the last to the bit, is left out.

Encoders and load cell have noise, so that no two readings are the same number: a repetition is a sensor that has
frozen. What is left out costs information and no more.
"""

from __future__ import annotations

from math import isfinite

from jawenv.compiled import njit

# Sd of the device's wrench about its recent mean, where a tick's samples cannot be used: what the motors can change.
LOST_FORCE, LOST_MOMENT = 3.0, 0.1


@njit
def mark_usable(measured, last, allowed, used):
    """Set ``used`` (12) where ``allowed`` readings are numbers and have changed; ``last`` becomes ``measured``.

    Returns how many allowed readings are left out.
    """
    left_out = 0
    for i in range(measured.shape[0]):
        good = isfinite(measured[i]) and measured[i] != last[i]
        used[i] = 1 if allowed[i] and good else 0
        if allowed[i] and not good:
            left_out += 1
        last[i] = measured[i]
    return left_out


@njit
def repair_samples(samples, last, trend, variance, usable):
    """Copy ``samples`` (3, 6) to ``usable``; a component that is missing or frozen there becomes its ``trend``.

    ``variance`` (6), that of the wrench not known, grows for those by ``LOST_FORCE`` or ``LOST_MOMENT`` squared;
    ``last`` (6) becomes the last sample. Returns how many components are replaced.
    """
    replaced = 0
    for k in range(samples.shape[1]):
        good, previous = True, last[k]
        for i in range(samples.shape[0]):
            good = good and isfinite(samples[i, k]) and samples[i, k] != previous
            previous = samples[i, k]
        last[k] = previous
        for i in range(samples.shape[0]):
            usable[i, k] = samples[i, k] if good else trend[k]
        if not good:
            lost = LOST_FORCE if k < 3 else LOST_MOMENT
            variance[k] += lost * lost
            replaced += 1
    return replaced
