"""The filter's work in one tick of the sensors, in an episode as in a record."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from jawenv.filter.basis import basis_dtype, build_basis
from jawenv.filter.cell_trend import follow_trend
from jawenv.filter.encoders import N_MEASUREMENTS
from jawenv.filter.joint_step import N_SAMPLES
from jawenv.filter.learn import belief_fields, learn
from jawenv.filter.measurement_update import (
    EXPECTED,
    REFUSED,
    SURPRISING,
    measurement_update_fields,
    update_motion,
)
from jawenv.filter.screening import mark_usable, repair_samples
from jawenv.filter.state import begin_belief, begin_motion, forget_readings
from jawenv.filter.time_update import predict_motion, time_update_fields
from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.records import record_dtype
from jawenv.mechanics.dynamics import N_WRENCH

# Initial ticks without information about the parameters on a jaw with two condyles: encoder noise of 0.1 mm is 10 N of
# disc force, which is not separable from muscle tension until the motion's covariance has settled.
SETTLING_TICKS = 10
# At the ends of windows of so many readings, each twice as long as the one before, all readings are filtered again,
# linearised at the updated mean, if a parameter's mean has moved by more than ``MOVED`` since they last were.
FIRST_WINDOW, LAST_WINDOW = 20, 1280
MOVED = 0.3  # of a natural logarithm


@cache
def filter_settings_dtype(n_muscles: int, n_states: int) -> np.dtype[np.void]:
    """Dtype of the filter's settings: device, prior and noise."""
    fields = [
        ("dt", "f8"),
        ("used", "u1", N_MEASUREMENTS),
        ("measurement_variance", "f8", N_MEASUREMENTS),
        ("wrench_variance", "f8", N_WRENCH),  # of the wrench not known
        ("gain_variance", "f8"),
        ("start_sd", "f8", n_states),  # of the motion before the first reading
        ("basis", basis_dtype(n_muscles)),
        ("prior_mean", "f8", (2 * n_muscles,)),
        ("prior_sd", "f8", (2 * n_muscles,)),
    ]
    return record_dtype(fields)


@cache
def tick_dtype(n_states: int) -> np.dtype[np.void]:
    """Dtype of what a replay of the filter reads of one tick: encoders at its end, load cell during it."""
    fields = [
        ("measured", "f8", N_MEASUREMENTS),
        ("samples", "f8", (N_SAMPLES, N_WRENCH)),
        ("believed", "f8", (n_states,)),  # motion before the first measurement; of row 0 alone
    ]
    return record_dtype(fields)


@cache
def filter_scratch_dtype(n_muscles: int, n_lines: int, n_states: int) -> np.dtype[np.void]:
    """Dtype of the filter's working memory, stage by stage."""
    stages: dict[str, list[Any]] = {
        "time": time_update_fields(n_muscles, n_lines, n_states),
        "update": measurement_update_fields(n_muscles, n_states),
        "belief": belief_fields(n_muscles),
    }
    fields: list[Any] = [(name, record_dtype(stage)) for name, stage in stages.items()]
    fields += [
        ("samples", "f8", (N_SAMPLES, N_WRENCH)),  # of the load cell, screened
        ("wrench_variance", "f8", N_WRENCH),
        ("used", "u1", N_MEASUREMENTS),  # readings, screened
        ("verdict", "i8"),  # what explains them, see ``measurement_update``
    ]
    return record_dtype(fields)


def set_prior(settings: Any, jaw: Any, prior: Any) -> None:
    """Write ``prior`` and the basis of tensions that spans it into ``settings``."""
    settings["basis"] = build_basis(jaw, prior)[0]
    settings["prior_mean"], settings["prior_sd"] = prior.mean, prior.sd


@njit
def begin_filter(belief, motion, settings):
    """Initialise the filter with the prior and the mean ``motion`` (n) before the first reading."""
    begin_motion(belief, motion, settings.start_sd)
    begin_belief(settings.basis, belief, settings.prior_mean, settings.prior_sd)
    belief.gated = 0


@njit
def take_readings(jaw, belief, measured, samples, tick, settings, scratch):
    """Predict over the tick with the load cell's ``samples`` (3, 6), then update with ``measured`` (12) at its end.

    Tick 0 is the start, at which the encoders alone are read. Returns how many readings were left out.
    """
    left_out = 0
    if tick > 0:
        scratch.wrench_variance[:] = settings.wrench_variance
        left_out += repair_samples(belief, samples, settings.dt, scratch.wrench_variance, scratch.samples)
        predict_motion(
            jaw, belief, scratch.samples, settings.dt, scratch.wrench_variance, settings.start_sd, scratch.time
        )
        follow_trend(belief.trend, scratch.samples, settings.dt)
    left_out += mark_usable(measured, belief.last_measured, settings.used, scratch.used)
    scratch.verdict = EXPECTED
    if scratch.used.any():
        belief.readings += 1
        variances, start_sd = settings.measurement_variance, settings.start_sd
        scratch.verdict = update_motion(jaw, belief, measured, variances, scratch.used, start_sd, scratch.update)
    if jaw.condyles == 2 and tick < SETTLING_TICKS:
        belief.score[:] = 0.0
        belief.information[:, :] = 0.0
    return left_out


@njit
def ends_window(belief, scratch):
    """Whether a window of readings ends with this tick."""
    if not scratch.used.any() or belief.readings > LAST_WINDOW:
        return False
    window = FIRST_WINDOW
    while window < belief.readings:
        window *= 2
    return belief.readings == window


@njit
def has_moved(belief):
    """Whether the mean is so far from where the readings were last filtered that they are to be filtered again."""
    furthest = 0.0
    for i in range(belief.mean.shape[0]):
        furthest = max(furthest, abs(belief.mean[i] - belief.replayed_at[i]))
    return furthest > MOVED


@njit
def replay(jaw, belief, rows, tick, settings, scratch):
    """Filter ``rows`` 0 to ``tick`` again, linearised at the current mean of the parameters.

    The first pass was linearised at earlier means. The information about the tensions hardly depends on them, but the
    filtered motion does. What the gate refuses is counted in the first pass alone.
    """
    belief.replayed_at[:] = belief.mean
    begin_motion(belief, rows[0].believed, settings.start_sd)
    forget_readings(belief)
    for k in range(tick + 1):
        take_readings(jaw, belief, rows[k].measured, rows[k].samples, k, settings, scratch)


@njit_within
def filter_tick(jaw, belief, rows, tick, measured, samples, settings, scratch):
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
    left_out = take_readings(jaw, belief, measured, samples, tick, settings, scratch)
    if scratch.verdict == REFUSED:
        belief.gated += 1
    if tick < rows.shape[0] and ends_window(belief, scratch):
        learn(belief, settings, scratch.belief)
        if has_moved(belief):
            replay(jaw, belief, rows, tick, settings, scratch)
            learn(belief, settings, scratch.belief)
    elif scratch.verdict == SURPRISING:
        learn(belief, settings, scratch.belief)
    return left_out
