"""Choice of the readings that the filter uses: one missing, out of range, or of a frozen sensor, is left out.

A sensor with noise and without steps never shows the same number twice: a repetition is a frozen sensor. One that
rounds to steps repeats itself by chance, and while nothing moves. So the step is learnt, as the largest of which all
changes so far are multiples (Euclid's algorithm). With steps, an encoder has frozen that stays equal while the motion
leaves it by more than step and noise, and a load cell whose components all stay equal while the jaw moves on. Only a
load cell without noise may repeat itself, as when no motor pushes. No jaw leaves the range. Leaving out a reading loses
its information and adds no bias.

A stop, a brake or teeth that act within a tick change its force by more than three samples resolve. The motion follows
the encoders then, and nothing is learnt of the muscles: where a linkage rattles for seconds, the same small error comes
back in every tick, and adds up to a belief that is far too sure.
"""

from __future__ import annotations

from math import hypot, inf, sqrt

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.belief.state import Belief, FilterSettings
from jawenv.filter.model.encoders import measure
from jawenv.filter.readings.least_noise import ENCODER_SDS, WRENCH_SDS
from jawenv.kernels.compiled import njit
from jawenv.mechanics.jaw import Jaw

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

# A step is none below this share of the least noise: noise then repeats a number less often than once in 300 readings.
FINEST = 0.01
SDS_OF_NOISE = 4.0  # by which, and by a step, an encoder that stays equal may differ from what is expected of it
STILL = 3e-3  # m by which the mouthpiece may move while a load cell with steps stays equal in all its components


def rough_change(cell_sd: NDArray[np.float64], dt: float) -> NDArray[np.float64]:
    """(3,) N by which a component of the force may change within a tick of ``dt`` s that is resolved.

    ``cell_sd`` (6,) are the load cell's sds of a tick's mean. In a longer tick the same motion changes it by more.
    """
    change: NDArray[np.float64] = np.maximum(ROUGH * max(1.0, dt / ROUGH_TICK), ROUGH_SDS * cell_sd[:3])
    return change


@njit
def _in_range(value, largest):
    """Whether ``value`` is a number of at most this magnitude."""
    return abs(value) <= largest


@njit
def _common_step(step, change, noise):
    """The largest step of which ``step`` and ``change`` are multiples; 0 where noise hides it, and then for ever."""
    change = abs(change)
    if step == 0.0 or not change > 0.0:
        return step
    if step == inf:
        return change
    while change > 0.1 * FINEST * noise:
        step, change = change, step % change
    return step if step > FINEST * noise else 0.0


@njit
def mark_usable(jaw: Jaw, belief: Belief, measured, settings: FilterSettings, scratch):
    """Set ``scratch.used`` where readings (12) are in range and of no frozen encoder; ``scratch.measured`` corrected.

    Returns how many readings of ``settings.used`` are left out.
    """
    left_out, expected_known = 0, False
    last, steps, repeats = belief.sensors.last_measured, belief.sensors.encoder_step, belief.sensors.repeats
    ranges = (POSITION, ANGLE, VELOCITY, RATE)
    for i in range(measured.shape[0]):
        good = _in_range(measured[i], ranges[i // 3])
        if good and measured[i] == last[i]:
            repeats[i] += 1.0
            if steps[i] != 0.0 and not expected_known:
                measure(jaw, belief.motion, scratch.update.rows, scratch.update.expected)
                expected_known = True
            noise = SDS_OF_NOISE * sqrt(settings.measurement_variance[i] / repeats[i])
            explained = noise + (steps[i] if steps[i] < inf else 0.0)
            if steps[i] == 0.0 or not abs(scratch.measured[i] - scratch.update.expected[i]) <= explained:
                repeats[i] = inf  # and frozen until it changes
            good = repeats[i] < inf
        elif good:
            repeats[i] = 0.0
            if _in_range(last[i], ranges[i // 3]):
                steps[i] = _common_step(steps[i], measured[i] - last[i], ENCODER_SDS[i // 3])
        scratch.used[i] = 1 if settings.used[i] and good else 0
        if settings.used[i] and not good:
            left_out += 1
        last[i] = measured[i]
    return left_out


@njit
def _has_moved_on(jaw: Jaw, belief: Belief, changed):
    """Whether the believed mouthpiece has moved by ``STILL`` since the load cell last ``changed``."""
    pose, at = belief.motion, belief.sensors.unchanged_at
    if changed:
        for i in range(5):
            at[i] = pose[i]
        return False
    shift, turn = 0.0, 0.0
    for i in range(2):
        shift = hypot(shift, pose[i] - at[i])
    for i in range(2, 5):
        turn = hypot(turn, pose[i] - at[i])
    moved_on = shift + hypot(jaw.mouthpiece[0], jaw.mouthpiece[2]) * turn > STILL
    if moved_on:
        at[0] = inf  # and so until it changes
    return moved_on


@njit
def mark_frozen(jaw: Jaw, belief: Belief, samples, settings: FilterSettings, frozen):
    """Set ``frozen`` (6) where the load cell's ``samples`` (3, 6) of a tick are equal and its step does not explain it.

    The first sample may be the last one of the tick before, as it is where a row has a single reading.
    """
    changed, steps = False, belief.sensors.cell_step
    for k in range(samples.shape[1]):
        first, middle, last = samples[0, k], samples[1, k], samples[2, k]
        frozen[k] = 1 if first == middle and middle == last and settings.cell_repeats[k] == 0 else 0
        changed = changed or not frozen[k]
        for change in (middle - first, last - middle):
            steps[k] = _common_step(steps[k], change, WRENCH_SDS[k // 3])
    moved_on = _has_moved_on(jaw, belief, changed)
    for k in range(samples.shape[1]):
        if steps[k] != 0.0 and not moved_on:
            frozen[k] = 0


@njit
def repair_samples(belief: Belief, samples, frozen, dt, variance, usable):
    """Copy ``samples`` (3, 6) to ``usable``; a missing or frozen component keeps its last usable value.

    Args:
        belief: State of the filter: last usable samples, time since then.
        samples: The load cell's in a tick.
        frozen: (6,) which components are.
        dt: Length of the tick, s.
        variance: (6,) process noise; grows with the time that a component is held.
        usable: (3, 6), overwritten.

    Returns:
        How many components are held.
    """
    held_sample, lost_for = belief.sensors.held_sample, belief.sensors.lost_for
    number = 0
    for k in range(samples.shape[1]):
        good = not frozen[k]
        for i in range(samples.shape[0]):
            good = good and _in_range(samples[i, k], FORCE if k < 3 else MOMENT)
        if good:
            held_sample[k], lost_for[k] = samples[samples.shape[0] - 1, k], 0.0
        else:
            lost_for[k] += dt
            sd = min(FORCE_RATE * lost_for[k], LOST_FORCE) if k < 3 else min(MOMENT_RATE * lost_for[k], LOST_MOMENT)
            variance[k] += sd * sd
            number += 1
        for i in range(samples.shape[0]):
            usable[i, k] = samples[i, k] if good else held_sample[k]
    return number


@njit
def is_resolved(belief: Belief, samples, rough, bites=False):
    """Whether a tick's ``samples`` (3, 6) of the load cell resolve it, and those before; called once for each tick.

    ``rough`` (3,) is as ``rough_change`` has it. None is in which the jaw ``bites``.
    """
    if belief.settling_ticks > 0:
        belief.settling_ticks -= 1
    belief.contact_ticks = SETTLING + 1 if bites else max(belief.contact_ticks - 1, 0)
    for k in range(3):
        first, middle, last = samples[0, k], samples[1, k], samples[2, k]
        if abs(last - first) > rough[k] or abs(last - 2.0 * middle + first) > rough[k]:
            belief.settling_ticks = SETTLING + 1
    return belief.settling_ticks == 0 and belief.contact_ticks == 0
