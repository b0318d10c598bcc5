"""Time update over one tick: the motion, its covariance, and its derivative by the tensions.

The force on the jaw is what the load cell reads, so that its noise and the wrench that no model explains enter the same
way. The relative gain error g of the load cell acts as g times the recent trend of the readings: a servo's force
answers to the jaw, and what of a reading answers to the filter's own errors must not pass for gain.
"""

from __future__ import annotations

from math import isfinite
from typing import Any

from jawenv.compiled import njit, njit_within
from jawenv.estimation.model.step import set_muscles
from jawenv.estimation.online.regressors import middle_of, set_line_wrenches
from jawenv.estimation.online.state import lose_motion, tension_columns
from jawenv.estimation.online.step import move, multiply, padded, step_dtype
from jawenv.mechanics.dynamics import N_WRENCH


def time_update_fields(n_muscles: int, n_lines: int, n_states: int) -> list[Any]:
    """Working memory of this file as fields of a dtype."""
    columns, inputs, wide = tension_columns(n_muscles), n_states + N_WRENCH, padded(n_states)
    return [
        ("step", step_dtype(n_lines, n_states)),
        ("start_motion", "f8", (n_states,)),
        ("line_wrench", "f8", (N_WRENCH, columns)),  # of each coefficient of size 1, at the mouthpiece, body axes
        ("total", "f8", (n_states, inputs)),  # [A, G]
        ("turned", "f8", (inputs, wide)),  # its transpose
        ("before", "f8", (inputs, columns)),  # ``by_tension`` above ``line_wrench``
        ("after", "f8", (n_states, columns)),
        ("cov", "f8", (n_states, wide)),
        ("moved_cov", "f8", (n_states, wide)),  # A P
        ("weighted", "f8", (n_states, inputs)),  # [A P, G W]
        ("next_cov", "f8", (n_states, wide)),
    ]


@njit_within
def predict_motion(jaw, belief, samples, dt, noise_variance, start_sd, scratch):
    """Advance ``belief`` by one tick under the load cell's ``samples`` (3, 6) at its start, middle and end.

    ``noise_variance`` (6) is that of the wrench not known, constant over the tick and new in each: what no model
    explains and the load cell's noise together. Where the prediction is no number, the motion stays as it was, and is
    known within ``start_sd`` (n).
    """
    set_muscles(jaw, belief.mean, 0, scratch.step.muscles)
    scratch.start_motion[:] = belief.motion
    move(jaw, belief.motion, samples, dt, scratch.step)
    if not all_finite(belief.motion):
        belief.motion[:] = scratch.start_motion
        lose_motion(belief, start_sd)
        return
    scratch.total[:, :] = scratch.step.total
    predict_cov(belief.motion_cov, noise_variance, scratch)
    pose, position = middle_of(jaw, scratch.start_motion, belief.motion)
    set_line_wrenches(jaw, belief.basis, belief.trend, pose, position, scratch.line_wrench)
    predict_by_tension(belief.by_tension, scratch)


@njit
def all_finite(values):
    """Whether all of ``values`` (n) are numbers."""
    total = 0.0
    for i in range(values.shape[0]):
        total += values[i]
    return isfinite(total)


@njit
def predict_cov(covariance, noise_variance, scratch):
    """P <- A P A^T + G W G^T."""
    total, weighted = scratch.total, scratch.weighted
    size, columns = total.shape
    for i in range(size):
        for j in range(size):
            scratch.cov[i, j] = covariance[i, j]
    multiply(total, scratch.cov, scratch.moved_cov)
    for i in range(size):
        for k in range(size):
            weighted[i, k] = scratch.moved_cov[i, k]
        for k in range(size, columns):
            weighted[i, k] = total[i, k] * noise_variance[k - size]
        for k in range(columns):
            scratch.turned[k, i] = total[i, k]
    multiply(weighted, scratch.turned, scratch.next_cov)
    for i in range(size):
        for j in range(size):
            # Of two numbers that differ by rounding, the same one for (i, j) and (j, i).
            covariance[i, j] = scratch.next_cov[max(i, j), min(i, j)]


@njit
def predict_by_tension(by_tension, scratch):
    """The motion's derivative by the tensions at the end of the tick: A times the last one, and G times the wrench."""
    size = by_tension.shape[0]
    scratch.before[:size, :] = by_tension
    scratch.before[size:, :] = scratch.line_wrench
    multiply(scratch.total, scratch.before, scratch.after)
    by_tension[:, :] = scratch.after
