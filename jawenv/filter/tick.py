"""The filter's work in one tick of the sensors, in an episode as in a record."""

from __future__ import annotations

from functools import cache
from math import hypot, sqrt
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.alarm.misfit import add_to_block
from jawenv.filter.belief.state import Belief, FilterSettings, begin_belief, begin_motion, forget_readings
from jawenv.filter.learn import LearnScratch, conclude, learn, learn_scratch_dtype
from jawenv.filter.model.basis import build_basis
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.joint_step import N_SAMPLES
from jawenv.filter.nuisances.changed_jaw import copy_jaw
from jawenv.filter.nuisances.changes import correct_readings, follow_friction, has_nuisances
from jawenv.filter.readings.cell_trend import SMOOTHING_TIME, follow_trend
from jawenv.filter.readings.screening import is_resolved, mark_frozen, mark_usable, repair_samples
from jawenv.filter.updates.measurement_update import (
    EXPECTED,
    REFUSED,
    SURPRISING,
    UpdateScratch,
    update_motion,
    update_scratch_dtype,
)
from jawenv.filter.updates.time_update import TimeScratch, predict_motion, time_scratch_dtype
from jawenv.kernels.compiled import njit, njit_within, where
from jawenv.kernels.records import Array, record_dtype
from jawenv.kernels.vec3 import apply, row3, vector3
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.forces import smooth_ramp
from jawenv.mechanics.jaw import N_TEETH, Jaw
from jawenv.mechanics.kinematics import contact_point, rotation

# Initial ticks without information about the parameters on a jaw with two condyles: encoder noise of 0.1 mm is 10 N of
# disc force, which is not separable from muscle tension until the motion's covariance has settled. Five suffice, and
# of ten the first moments of a quick opening are missed, which tell parameters apart that later ones leave alike.
SETTLING_TICKS = 5
# At the ends of windows of so many readings, each twice as long as the one before, all readings are filtered again,
# linearised at the updated mean, if a parameter's mean has moved by more than ``MOVED`` since they last were.
FIRST_WINDOW, LAST_WINDOW = 5, 20480
MOVED = 0.3  # of a natural logarithm
# What the model has wrong at a pose it has wrong within so many m; the ticks that this takes are counted from so many
# m/s on, and up to so many. The moment's error is the force's at so many m.
ALIKE, SLOWEST, MOST_TICKS, LASTING_ARM = 1e-3, 1e-3, 100.0, 0.03
STAY_S, LEAST = 1.0, 3e-5
# m: nothing is learnt while teeth are nearer. The error of their force lasts as long as they press, and is no noise;
# nor do the encoders show whether they press lightly.
NEAR = 1e-4
LOST_SDS = 300.0  # of the motion before the first reading: of the motion that a wrong belief predicts beside the teeth
# Sd of each component of the wrench over the teeth's force; the last three in m.
TOOTH_NOISE = (0.1, 0.1, 0.2, 0.006, 0.008, 0.002)


class Tick:
    """One tick's readings for a replay of the filter: encoders at its end, load cell during it."""

    measured: Annotated[Array, N_MEASUREMENTS]
    samples: Annotated[Array, N_SAMPLES, N_WRENCH]
    believed: Annotated[Array, "states"]  # motion before the first measurement; of row 0 alone


@cache
def tick_dtype(n_states: int) -> np.dtype[np.void]:
    """Dtype of ``Tick``."""
    return record_dtype(Tick, states=n_states)


class FilterScratch:
    """The filter's working memory, stage by stage."""

    time: TimeScratch
    update: UpdateScratch
    belief: LearnScratch
    samples: Annotated[Array, N_SAMPLES, N_WRENCH]  # of the load cell, screened
    frozen: Annotated[NDArray[np.uint8], N_WRENCH]  # which components of it
    wrench_variance: Annotated[Array, N_WRENCH]
    used: Annotated[NDArray[np.uint8], N_MEASUREMENTS]  # readings, screened
    measured: Annotated[Array, N_MEASUREMENTS]  # corrected
    verdict: int  # what explains them, see ``measurement_update``


@cache
def filter_scratch_dtype(
    n_muscles: int, n_lines: int, n_states: int, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of ``FilterScratch``."""
    return record_dtype(
        FilterScratch,
        time=time_scratch_dtype(n_muscles, n_lines, n_states, n_nuisances, n_disturbance),
        update=update_scratch_dtype(n_muscles, n_lines, n_states + n_disturbance, n_nuisances),
        belief=learn_scratch_dtype(n_muscles, n_nuisances),
    )


def set_prior(settings: Any, jaw: Any, prior: Any) -> None:
    """Write ``prior`` and the basis of tensions that spans it into ``settings``."""
    settings["basis"] = build_basis(jaw, prior)[0]
    settings["prior_mean"], settings["prior_sd"] = prior.mean, prior.sd


@njit
def begin_filter(jaw: Jaw, belief: Belief, motion, settings: FilterSettings):
    """Initialise the filter with the prior and the mean ``motion`` (n) before the first reading."""
    if belief.nuisances.shape[0] > 0:
        copy_jaw(jaw, belief.jaw)
    begin_motion(belief, motion, settings.start_sd)
    begin_belief(settings.basis, belief, settings.prior_mean, settings.prior_sd)
    belief.nuisance_factor[0, 0] = sqrt(settings.gain_variance)
    belief.gated = 0


@njit
def bite_of(jaw: Jaw, motion, nearer=0.0):
    """Force (N) with which the teeth press, or would press if they were ``nearer`` (m)."""
    first = 3 if jaw.condyles == 2 else 2  # of the angles
    pose = (motion[0], motion[1], motion[first], motion[first + 1], motion[first + 2])
    return bite_at(jaw, contact_point(jaw, pose)[2] + nearer, rotation(pose))


@njit
def bite_at(jaw: Jaw, height, body_to_head):
    """Force (N) of the teeth with the contact point so high (m)."""
    bite = 0.0
    for i in range(N_TEETH):
        arm = apply(body_to_head, row3(jaw.teeth, i))
        ramp, _ = smooth_ramp(height + arm[2] - jaw.teeth[i, 2], jaw.stop_width)
        bite += jaw.tooth_stiffness * ramp
    return bite


@njit
def reads_pose(used):
    """Whether the encoders in use (12) tell how near the teeth are."""
    return used[2] and used[3] and used[4] and used[5]


@njit
def bite_read(jaw: Jaw, measured, nearer):
    """``bite_of`` the pose that the encoders read (12).

    A belief that has one side too stiff or too soft takes a jaw for lifted that rests on the teeth of one side.
    """
    body_to_head = rotation((0.0, 0.0, measured[3], measured[4], measured[5]))
    height = measured[2] + (0.0 if jaw.condyles == 2 else jaw.zero[2])
    return bite_at(jaw, height - apply(body_to_head, vector3(jaw.mouthpiece))[2] + nearer, body_to_head)


@njit
def forget_motion(jaw: Jaw, belief: Belief, sd):
    """Widen the motion beyond what the encoders read, which it is then: no model of teeth and muscles is in it."""
    for i in range(12 if jaw.condyles == 2 else 10):
        belief.motion_cov[i, :] = 0.0
        belief.motion_cov[:, i] = 0.0
        belief.motion_cov[i, i] = LOST_SDS * LOST_SDS * sd[i] * sd[i]
    belief.by_tension[:, :] = 0.0


@njit
def add_tooth_noise(bite, variance):
    """Add to the process noise ``variance`` (6) what the force ``bite`` (N) of the teeth may be off by.

    Nobody knows what teeth and their ligament do: a fifth of the force upwards, half of that across, and the moments of
    both about the mouthpiece.
    """
    for k in range(N_WRENCH):
        sd = TOOTH_NOISE[k] * bite
        variance[k] += sd * sd


@njit
def stay_of(jaw: Jaw, belief: Belief, dt):
    """Ticks that the mouthpiece takes for ``ALIKE`` at its velocity, smoothed over ``STAY_S``."""
    slide, turning = (6, 9) if jaw.condyles == 2 else (5, 7)
    last = turning + 3
    share = dt / STAY_S
    shift, turn = 0.0, 0.0
    for i in range(slide, last):
        drift = belief.drifting[i - slide] + share * (belief.motion[i] - belief.drifting[i - slide])
        belief.drifting[i - slide] = drift
        if i < turning:
            shift = hypot(shift, drift)
        else:
            turn = hypot(turn, drift)
    return ALIKE / (dt * max(shift + jaw.mouthpiece[0] * turn, LEAST))


@njit
def weight_of_stay(jaw: Jaw, belief: Belief, settings: FilterSettings):
    """What a tick's readings count for, as the model may have something wrong at a pose while the jaw is there.

    An error of so large a share of the force that is carried is alike within ``ALIKE``. After n ticks there with white
    noise of variance r these have told n / (r + n s) about the force, with s the error's variance. One more tells the
    derivative, r / (r + n s)^2, in place of 1 / r: a jaw that stays where it is learns no more than 1 / s. As noise of
    the motion it would make the motion follow the encoders' noise, which biases what is learnt.
    """
    stay = stay_of(jaw, belief, settings.dt)
    trend = belief.trend
    carried = sqrt(trend[0] * trend[0] + trend[1] * trend[1] + trend[2] * trend[2]) + jaw.mass * -jaw.gravity[2]
    error = settings.lasting * carried
    noise = (settings.wrench_variance[0] + settings.wrench_variance[1] + settings.wrench_variance[2]) / 3.0
    return noise / (noise + stay * error * error)


@njit
def add_lasting_noise(jaw: Jaw, belief: Belief, settings: FilterSettings, variance):
    """Add to the process noise ``variance`` (6) what the model may have wrong at a pose while the jaw is there.

    An error of so large a share of the force that is carried, alike within ``ALIKE``, is as much noise per tick as the
    ticks that the jaw takes for that way: a maneuver that stays where it is learns no more than it sees.
    """
    motion, trend = belief.motion, belief.trend
    slide, turning = (6, 9) if jaw.condyles == 2 else (5, 7)
    turn = abs(motion[turning]) + abs(motion[turning + 1]) + abs(motion[turning + 2])
    speed = abs(motion[slide]) + jaw.mouthpiece[0] * turn
    carried = sqrt(trend[0] * trend[0] + trend[1] * trend[1] + trend[2] * trend[2]) + jaw.mass * -jaw.gravity[2]
    ticks = min(ALIKE / (settings.dt * max(speed, SLOWEST)), MOST_TICKS)
    error = settings.lasting * carried
    for k in range(3):
        variance[k] += ticks * error * error
        variance[3 + k] += ticks * error * error * LASTING_ARM * LASTING_ARM


def _known_jaw(jaw: Jaw, belief: Belief):
    return jaw


@where(has_nuisances, otherwise=_known_jaw)
def model_of(jaw: Jaw, belief: Belief):
    """The jaw for the filter: the nominal one, or with nuisances the one at their mean."""
    return belief.jaw


@njit
def take_readings(jaw: Jaw, belief: Belief, measured, samples, tick, settings: FilterSettings, scratch: FilterScratch):
    """Predict over the tick with the load cell's ``samples`` (3, 6), then update with ``measured`` (12) at its end.

    Tick 0 is the start, at which the encoders alone are read. Returns how many readings were left out.
    """
    return take(model_of(jaw, belief), belief, measured, samples, tick, settings, scratch)


@njit
def take(jaw: Jaw, belief: Belief, measured, samples, tick, settings: FilterSettings, scratch: FilterScratch):
    """``take_readings`` by the model ``jaw``."""
    left_out, resolved, bite, weight = 0, True, 0.0, 1.0
    if tick > 0:
        scratch.wrench_variance[:] = settings.wrench_variance
        mark_frozen(jaw, belief, samples, settings, scratch.frozen)
        left_out += repair_samples(
            belief, samples, scratch.frozen, settings.dt, scratch.wrench_variance, scratch.samples
        )
        add_tooth_noise(bite_of(jaw, belief.motion), scratch.wrench_variance)
        bite = bite_of(jaw, belief.motion, NEAR)
        add_lasting_noise(jaw, belief, settings, scratch.wrench_variance)
        predict_motion(jaw, belief, scratch.samples, scratch.wrench_variance, settings, scratch.time)
        follow_trend(belief.trend, scratch.samples, settings.dt)
        follow_trend(belief.smoothed, scratch.samples, settings.dt, SMOOTHING_TIME)
        bite = max(bite, bite_of(jaw, belief.motion, NEAR))
    correct_readings(belief, settings.nuisances, measured, scratch.measured)
    left_out += mark_usable(jaw, belief, measured, settings, scratch)
    if tick > 0:
        sees = reads_pose(scratch.used)
        if sees:
            bite = max(bite, bite_read(jaw, scratch.measured, NEAR))
        if belief.nuisances.shape[0] > 0:
            weight = weight_of_stay(jaw, belief, settings)
        settling = SETTLING_TICKS if jaw.condyles == 2 else 0
        resolved = is_resolved(belief, scratch.samples, settings.rough, bite > 0.0, settling)
        if sees and belief.near > settling:
            forget_motion(jaw, belief, settings.start_sd)
    scratch.verdict = EXPECTED
    if scratch.used.any():
        belief.readings += resolved
        used = scratch.used
        scratch.verdict = update_motion(jaw, belief, scratch.measured, used, resolved * weight, settings, scratch.update)
        if resolved and scratch.verdict != REFUSED and not settings.motion_only:
            add_to_block(belief, scratch.update)
    if tick > 0:
        follow_friction(jaw, belief, settings, scratch.time)
    if jaw.condyles == 2 and tick < SETTLING_TICKS:
        belief.score[:] = 0.0
        belief.information[:, :] = 0.0
    return left_out


@njit
def ends_window(belief: Belief):
    """Whether a window of readings ends with the last one."""
    if belief.readings > LAST_WINDOW:
        return False
    window = FIRST_WINDOW
    while window < belief.readings:
        window *= 2
    return belief.readings == window


@njit
def has_moved(belief: Belief):
    """Whether the mean is so far from where the readings were last filtered that they are to be filtered again."""
    furthest = 0.0
    for i in range(belief.mean.shape[0]):
        furthest = max(furthest, abs(belief.mean[i] - belief.replayed_at[i]))
    for j in range(belief.nuisances.shape[0]):
        furthest = max(furthest, abs(belief.nuisances[j] - belief.nuisances_replayed_at[j]))
    return furthest > MOVED


@njit
def replay(jaw: Jaw, belief: Belief, rows, tick, settings: FilterSettings, scratch: FilterScratch):
    """Filter ``rows`` 0 to ``tick`` again, linearised at the current mean of the parameters.

    The first pass was linearised at earlier means. The information about the tensions hardly depends on them, but the
    filtered motion does. What the gate refuses is counted in the first pass alone.
    """
    belief.replayed_at[:] = belief.mean
    belief.nuisances_replayed_at[:] = belief.nuisances
    begin_motion(belief, rows[0].believed, settings.start_sd)
    forget_readings(belief)
    for k in range(tick + 1):
        take_readings(jaw, belief, rows[k].measured, rows[k].samples, k, settings, scratch)


@njit_within
def filter_tick(
    jaw: Jaw, belief: Belief, rows, tick, measured, samples, settings: FilterSettings, scratch: FilterScratch
):
    """One tick of the filter. Returns how many readings were left out.

    The belief is renewed where a window of readings ends, and where the parameters' uncertainty alone explains what was
    read: the motion is linearised about a belief that is far from the truth.

    Args:
        jaw: The filter's model.
        belief: Record of dtype ``belief_dtype``.
        rows: (any number) records of dtype ``tick_dtype``, of the ticks so far, for replays.
        tick: Its number.
        measured: (12,) encoders at its end.
        samples: (3, 6) of the load cell during it.
        settings: See ``filter_settings_dtype``.
        scratch: Working memory.
    """
    before = belief.readings
    left_out = take_readings(jaw, belief, measured, samples, tick, settings, scratch)
    if settings.motion_only:
        return left_out
    if scratch.verdict == REFUSED:
        belief.gated += 1
    if belief.readings > before and tick <= min(LAST_WINDOW, rows.shape[0] - 1) and ends_window(belief):
        learn(belief, settings, scratch.belief)
        if has_moved(belief):
            replay(jaw, belief, rows, tick, settings, scratch)
            conclude(belief, settings, scratch.belief)
    elif scratch.verdict == SURPRISING:
        learn(belief, settings, scratch.belief)
    return left_out
