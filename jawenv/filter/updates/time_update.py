"""Time update over one tick: the motion, its covariance, and its derivative by the tensions.

The load cell's reading is the input, so its noise and the unmodelled wrench enter alike, as process noise. The relative
gain error g of the load cell acts as g times the force that the pose needs (``balance``). What is left of the reading
is g times inertia and damping. In a jaw that is held, most of what is learnt is from small motions, in which a servo's
answer is inertia: without it g would be believed to be 0, too surely. But the predicted acceleration has the motion's
noise, which would tell of g as well. So g times inertia is a number of its own, which is integrated out. That of
damping makes no difference (300 s of slow opening and of stretches held, 24 patients).
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.filter.belief.state import Belief, FilterSettings, lose_motion, tension_columns
from jawenv.filter.model.motion_step import N_SAMPLES, Step, move, predict_cov, set_muscles, step_dtype
from jawenv.filter.model.regressors import middle_of, set_accelerating, set_balanced, set_line_wrenches
from jawenv.filter.nuisances.if_any import (
    NuisanceScratch,
    correct_samples,
    nuisance_scratch_dtype,
    set_nuisance_wrenches,
)
from jawenv.filter.updates.disturbance import add_disturbance, decay_disturbance, set_total
from jawenv.filter.updates.instrument import (
    Instrument,
    all_finite,
    instrument_dtype,
    is_early,
    predict_from_past,
)
from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.linalg import multiply
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import split


class TimeScratch:
    """Working memory of the time update."""

    step: Step
    nuisances: NuisanceScratch
    start_motion: Annotated[Array, "motion"]
    instrument: Instrument
    driven: Annotated[Array, N_SAMPLES, N_WRENCH]  # the samples and the disturbance
    line_wrench: Annotated[Array, N_WRENCH, "columns"]  # of each coefficient of size 1, at the mouthpiece, body axes
    trend: Annotated[Array, N_WRENCH]  # of the load cell, balanced
    accelerating: Annotated[Array, N_WRENCH]
    total: Annotated[Array, "motion", "inputs"]  # [A, G]
    turned: Annotated[Array, "inputs", "motion"]  # its transpose
    before: Annotated[Array, "inputs", "columns"]  # ``by_tension`` above ``line_wrench``
    after: Annotated[Array, "motion", "columns"]
    moved_cov: Annotated[Array, "motion", "motion"]  # A P
    weighted: Annotated[Array, "motion", "inputs"]  # [A P, G W]
    next_cov: Annotated[Array, "motion", "motion"]


@cache
def time_scratch_dtype(
    n_muscles: int, n_lines: int, n_states: int, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of ``TimeScratch``."""
    n_motion = n_states + n_disturbance
    columns, inputs = tension_columns(n_muscles, n_nuisances), n_motion + N_WRENCH
    return record_dtype(
        TimeScratch,
        step=step_dtype(n_lines, n_states),
        nuisances=nuisance_scratch_dtype(n_lines, n_nuisances),
        motion=n_motion,
        instrument=instrument_dtype(n_states),
        columns=columns,
        inputs=inputs,
    )


@njit_within
def predict_motion(jaw: Jaw, belief: Belief, samples, noise_variance, settings: FilterSettings, scratch: TimeScratch):
    """Advance ``belief`` by one tick under the load cell's ``samples`` (3, 6) at its start, middle and end.

    The samples are corrected in place by what the belief knows of nuisances.

    ``noise_variance`` (6) is the process noise: unmodelled wrench and load-cell noise, constant over a tick and
    independent between ticks. Where the prediction is not finite, the mean of the motion stays and its covariance
    becomes that of the ``settings``' ``start_sd`` (n).
    """
    dt, start_sd = settings.dt, settings.start_sd
    set_muscles(jaw, belief.point, scratch.step.muscles)
    scratch.start_motion[:] = belief.motion
    predict_from_past(jaw, belief, dt, scratch)
    correct_samples(jaw, belief, settings, samples, scratch)
    add_disturbance(belief, scratch.instrument.motion.shape[0], samples, scratch.driven)
    early = is_early(belief)
    move(jaw, belief.motion, scratch.driven, dt, early, scratch.step)
    if early:
        for i in range(belief.predicted.shape[0]):
            belief.predicted[i] = belief.motion[i]
    if not (all_finite(belief.motion) and all_finite(scratch.instrument.motion)):
        belief.motion[:] = scratch.start_motion
        for i in range(scratch.instrument.motion.shape[0]):
            belief.predicted[i] = scratch.start_motion[i]
        lose_motion(belief, start_sd)
        return
    step, size = scratch.step.total, scratch.total.shape[0]
    set_total(step, step.shape[0], settings.disturbance_decay, size, scratch.total)
    predict_cov(belief.motion_cov, noise_variance, scratch)
    decay_disturbance(belief, settings)
    if settings.motion_only:
        return
    pose, position = middle_of(jaw, scratch.start_motion, scratch.instrument.motion)
    set_balanced_trend(jaw, belief, pose, scratch)
    set_line_wrenches(jaw, belief.basis, scratch.trend, pose, position, scratch.line_wrench)
    set_inertia_column(jaw, belief, pose, dt, scratch)
    set_nuisance_wrenches(jaw, scratch.step.muscles, belief, pose, settings, scratch)
    predict_by_tension(belief.by_tension, scratch)


@njit
def set_balanced_trend(jaw: Jaw, belief: Belief, pose, scratch: TimeScratch):
    """Set ``scratch.trend`` (6) to the trend of the load cell that the pose needs.

    Where damping is unknown as well, that of the motion.
    """
    _, u = split(scratch.start_motion)
    if belief.nuisances.shape[0] == 0:
        u = (0.0, 0.0, 0.0, 0.0, 0.0)
    set_balanced(jaw, scratch.step.muscles, pose, u, belief.trend, scratch.trend)


@njit
def set_inertia_column(jaw: Jaw, belief: Belief, pose, dt, scratch: TimeScratch):
    """The wrench of the predicted acceleration, by which the gain error is a number of its own (``shared_columns``)."""
    if belief.nuisances.shape[0] > 0:
        return
    (_, u), (_, after) = split(scratch.start_motion), split(scratch.instrument.motion)
    set_accelerating(jaw, pose, _rate_of(u, after, dt), scratch.accelerating)
    column = belief.nominal.shape[0] * belief.nominal.shape[1] + 1
    for k in range(N_WRENCH):
        scratch.line_wrench[k, column] = scratch.accelerating[k]


@njit
def _rate_of(before, after, dt):
    """Change of five numbers in a second, from ``before`` to ``after``, ``dt`` (s) later."""
    return (
        (after[0] - before[0]) / dt,
        (after[1] - before[1]) / dt,
        (after[2] - before[2]) / dt,
        (after[3] - before[3]) / dt,
        (after[4] - before[4]) / dt,
    )


@njit
def predict_by_tension(by_tension, scratch: TimeScratch):
    """The motion's derivative by the tensions at the end of the tick: A times the last one, and G times the wrench."""
    size = by_tension.shape[0]
    scratch.before[:size, :] = by_tension
    scratch.before[size:, :] = scratch.line_wrench
    multiply(scratch.total, scratch.before, scratch.after)
    by_tension[:, :] = scratch.after
