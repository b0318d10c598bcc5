"""The filter's work in one tick of the sensors, in an episode as in a record.

``take`` does these in this order; each reads what those before it wrote.

| # | step | reads | writes |
|--:|---|---|---|
| 1 | ``mark_frozen``, ``repair_samples`` | load cell | ``samples``, ``frozen``, ``wrench_variance`` |
| 2 | ``add_tooth_noise`` | motion | ``wrench_variance`` |
| 3 | ``add_model_error`` | motion, its rates | ``wrench_variance`` |
| 4 | ``predict_motion`` | 1 to 3 | motion, covariance, derivative by tensions |
| 5 | ``follow_trend`` | 1 | ``trend``, ``smoothed`` |
| 6 | ``correct_readings``, ``mark_usable`` | encoders, nuisances | ``scratch.measured``, ``used`` |
| 7 | ``bite_force``, ``read_bite`` | 4, 6 | ``bite``: whether teeth press |
| 8 | ``reading_weight`` | 4 | ``weight``, visits of poses |
| 9 | ``is_resolved`` | 1, 7 | whether anything is learnt |
| 10 | ``forget_motion`` | 7 | motion as encoders alone have it |
| 11 | ``update_motion`` | 4 to 9 | motion, information, score, verdict of the gate |
| 12 | ``add_to_block`` | innovations of 11 | the alarm's sums |
| 13 | ``follow_friction`` | motion | shares of motors' friction |

``filter_tick`` then learns, and filters readings again, where a window ends or a reading surprises. What each step is
worth is in docs/tables/ablation.md: none of those that it leaves out goes without loss.
"""

from __future__ import annotations

from functools import cache
from math import sqrt
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.alarm.drift import is_due
from jawenv.filter.alarm.misfit import add_to_block
from jawenv.filter.belief.refocus import refocus
from jawenv.filter.belief.state import Belief, FilterSettings, begin_belief, begin_motion, forget_readings
from jawenv.filter.learn import LearnScratch, conclude, keep_passing, learn, learn_scratch_dtype, recentre
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.filter.nuisances.if_any import begin_jaw, correct_readings, follow_friction, no_nuisances
from jawenv.filter.readings.cell_trend import SMOOTHING_TIME, follow_trend
from jawenv.filter.readings.model_error import add_model_error, reading_weight
from jawenv.filter.readings.screening import is_resolved, mark_frozen, mark_usable, repair_samples
from jawenv.filter.readings.teeth import LEAST_GAP, add_tooth_noise, bite_force, forget_motion, read_bite, reads_pose
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
from jawenv.kernels.records import Array, copy_record, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw

# At the ends of windows of so many readings, each twice as long as the one before, readings are filtered again,
# linearised at the updated mean, if a parameter's mean has moved by more than ``MOVED`` and ``MOVED_SDS`` since they
# last were.
FIRST_WINDOW, LAST_WINDOW = 5, 20480
MOVED, MOVED_SDS = 0.05, 1.4  # of a natural logarithm; sds of the present belief
# All are, until every sd is below ``CONVERGED_SD``. Then those since the last time are, from the belief that was
# kept: forces are linear in coefficients of tension, so that readings once linearised near the truth need not be read
# again. A count of readings or ticks in its place loses people whose jaws are known within a factor of ten at first.
# Nuisances move on: with these all are read again.
CONVERGED_SD = 0.1


ROW = np.dtype([("measured", np.float32, N_MEASUREMENTS), ("samples", np.float32, (N_SAMPLES, N_WRENCH))], align=True)
"""One tick's readings for a replay of the filter: encoders at its end, load cell during it. Nearly all of a world's
memory are rows of it, so that they have no padding and single precision, to which all readings are rounded."""


class FilterScratch:
    """The filter's working memory, stage by stage."""

    time: TimeScratch
    update: UpdateScratch
    belief: LearnScratch
    samples: Annotated[Array, N_SAMPLES, N_WRENCH]  # of the load cell, screened
    frozen: Annotated[NDArray[np.uint8], N_WRENCH]  # which components of it
    wrench_variance: Annotated[Array, N_WRENCH]
    before: Annotated[Array, "motion"]  # the motion, before the time update
    used: Annotated[NDArray[np.uint8], N_MEASUREMENTS]  # readings, screened
    measured: Annotated[Array, N_MEASUREMENTS]  # corrected
    row_measured: Annotated[Array, N_MEASUREMENTS]  # of the row that is filtered again
    row_samples: Annotated[Array, N_SAMPLES, N_WRENCH]
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
        motion=n_states + n_disturbance,
    )


@njit
def begin_filter(jaw: Jaw, belief: Belief, motion, settings: FilterSettings):
    """Initialise the filter with the prior and the mean ``motion`` (n) before the first reading."""
    begin_jaw(jaw, belief)
    begin_motion(belief, motion, settings.start_sd)
    begin_belief(settings.basis, belief, settings.prior_mean, settings.prior_sd)
    for k in range(belief.nuisance_factor.shape[0] - belief.nuisances.shape[0]):
        belief.nuisance_factor[k, k] = sqrt(settings.gain_variance)
    belief.replayed = 0


def _jaw_at_mean(jaw: Jaw, belief: Belief):
    return belief.jaw


@where(no_nuisances, otherwise=_jaw_at_mean)
def _model_of(jaw: Jaw, belief: Belief):
    """The jaw for the filter: the nominal one, or with nuisances the one at their mean."""
    return jaw


@njit
def take_readings(jaw: Jaw, belief: Belief, measured, samples, tick, settings: FilterSettings, scratch: FilterScratch):
    """Predict over the tick with the load cell's ``samples`` (3, 6), then update with ``measured`` (12) at its end.

    Tick 0 is the start, at which the encoders alone are read. Returns how many readings were left out.
    """
    return take(_model_of(jaw, belief), belief, measured, samples, tick, settings, scratch)


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
        add_tooth_noise(bite_force(jaw, belief.motion), scratch.wrench_variance)
        bite = bite_force(jaw, belief.motion, LEAST_GAP)
        add_model_error(jaw, belief, settings, scratch.wrench_variance)
        scratch.before[:] = belief.motion
        predict_motion(jaw, belief, scratch.samples, scratch.wrench_variance, settings, scratch.time)
        follow_trend(belief.trend, scratch.samples, settings.dt)
        follow_trend(belief.smoothed, scratch.samples, settings.dt, SMOOTHING_TIME)
        bite = max(bite, bite_force(jaw, belief.motion, LEAST_GAP))
    correct_readings(belief, settings.nuisances, measured, scratch.measured)
    left_out += mark_usable(jaw, belief, measured, settings, scratch)
    if tick > 0:
        sees = reads_pose(scratch.used, settings.measurement_variance)
        if sees:
            bite = max(bite, read_bite(jaw, scratch.measured, LEAST_GAP))
        weight = reading_weight(jaw, belief, settings)
        resolved = is_resolved(belief, scratch.samples, settings.rough, bite > 0.0)
        if sees and belief.contact_ticks > 0:
            forget_motion(jaw, belief, scratch.before, settings.start_sd)
    scratch.verdict = EXPECTED
    if scratch.used.any():
        belief.readings += resolved
        used = scratch.used
        weight = weight if resolved else 0.0
        scratch.verdict = update_motion(jaw, belief, scratch.measured, used, weight, settings, scratch.update)
        if resolved and scratch.verdict != REFUSED and not settings.motion_only:
            add_to_block(jaw, belief, scratch.update)
    if tick > 0:
        follow_friction(jaw, belief, settings, scratch.time)
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
    furthest, sds = 0.0, 0.0
    for i in range(belief.mean.shape[0]):
        moved = abs(belief.mean[i] - belief.replayed_at[i])
        furthest, sds = max(furthest, moved), max(sds, moved / sqrt(belief.cov[i, i]))
    for j in range(belief.nuisances.shape[0]):
        if abs(belief.nuisances[j] - belief.nuisances_replayed_at[j]) > MOVED:
            return True
    return furthest > MOVED and sds > MOVED_SDS


@njit
def read_row(row, scratch: FilterScratch):
    """The readings of a row, (12,) and (3, 6), in double precision until the next one is read."""
    scratch.row_measured[:] = row.measured
    scratch.row_samples[:, :] = row.samples
    return scratch.row_measured, scratch.row_samples


def _first_of_all(belief: Belief, kept: Belief, settings: FilterSettings, scratch: FilterScratch):
    return 0


@where(no_nuisances, otherwise=_first_of_all)
def _return_to(belief: Belief, kept: Belief, settings: FilterSettings, scratch: FilterScratch):
    """Once the muscles are nearly known, return to what the last replay left, at the present mean.

    Returns the first row to filter again.
    """
    for i in range(belief.mean.shape[0]):
        if belief.replayed == 0 or belief.cov[i, i] > CONVERGED_SD * CONVERGED_SD:
            return 0
    first = belief.replayed + 1
    kept.mean[:], kept.cov[:, :] = belief.mean, belief.cov
    kept.replayed_at[:] = belief.replayed_at
    copy_record(belief, kept)
    recentre(belief, settings, scratch.belief)
    refocus(belief, scratch.belief)
    return first


@where(no_nuisances)
def _keep(belief: Belief, kept: Belief):
    """Let ``kept`` be the belief."""
    copy_record(kept, belief)


@njit
def replay(jaw: Jaw, beliefs, rows, tick, settings: FilterSettings, scratch: FilterScratch):
    """Filter rows up to ``tick`` again, linearised at the present mean of the parameters.

    The first pass was linearised at earlier means. The information about the tensions hardly depends on them, but the
    filtered motion does.
    """
    belief, kept = beliefs
    belief.replayed_at[:] = belief.mean
    belief.nuisances_replayed_at[:] = belief.nuisances
    first = _return_to(belief, kept, settings, scratch)
    if first == 0:
        begin_motion(belief, belief.began, settings.start_sd)
        forget_readings(belief)
    for k in range(first, tick + 1):
        measured, samples = read_row(rows[k], scratch)
        take_readings(jaw, belief, measured, samples, k, settings, scratch)
        if is_due(belief):
            keep_passing(belief, settings, scratch.belief)
    belief.replayed = tick


@njit_within
def filter_tick(jaw: Jaw, beliefs, rows, tick, measured, samples, settings: FilterSettings, scratch: FilterScratch):
    """One tick of the filter. Returns how many readings were left out, and whether the gate refused the others.

    The belief is renewed where a window of readings ends, and where the parameters' uncertainty alone explains what was
    read: the motion is linearised about a belief that is far from the truth.

    Args:
        jaw: The filter's model.
        beliefs: Two records of dtype ``belief_dtype``: the belief, and what the last replay has left.
        rows: (any number) records of dtype ``ROW``, of the ticks so far, for replays.
        tick: Its number.
        measured: (12,) encoders at its end.
        samples: (3, 6) of the load cell during it.
        settings: See ``filter_settings_dtype``.
        scratch: Working memory.
    """
    belief, kept = beliefs
    before = belief.readings
    left_out = take_readings(jaw, belief, measured, samples, tick, settings, scratch)
    refused = scratch.verdict == REFUSED
    if settings.motion_only:
        return left_out, False
    if belief.readings > before and tick <= min(LAST_WINDOW, rows.shape[0] - 1) and ends_window(belief):
        learn(belief, settings, scratch.belief)
        if has_moved(belief):
            replay(jaw, beliefs, rows, tick, settings, scratch)
            conclude(belief, settings, scratch.belief)
            _keep(belief, kept)
    elif scratch.verdict == SURPRISING:
        learn(belief, settings, scratch.belief)
    return left_out, refused
