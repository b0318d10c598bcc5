"""The online filter: motion filtered at the present estimate, information about the muscles gathered beside it.

Three things are carried from tick to tick (Friedland 1969, IEEE Trans. Autom. Control 14:359, the bias-separated form
of the Kalman filter):

* the motion (q, u) and its covariance, as if the muscles were known to be what the belief's mean says;
* ``by_tension``, by how much that motion would differ if the muscles were others: its derivative by the coefficients c
  of ``tension_basis`` and by the load cell's gain error;
* the information that the innovations hold about those: matrix and score of a quadratic log-likelihood.

Forces are linear in c, so that the information of early data, gathered about a poor guess, holds as well as that of
late data. No noise has to be put on the parameters, which are constants. What is carried, and the belief that is made
of it, are in ``tension_belief``.

The force on the jaw is the reading plus g times the reading. The load cell's noise is in the reading and so in the
motion: ``noisy_input`` rids the score of what it would bias. Where servo or brake answers to the jaw, g multiplies
the recent trend of the readings instead, for what they answer to the filter's own errors is too much of a reading.
"""

from __future__ import annotations

from math import log
from typing import Any

import numpy as np

from jawenv.compiled import njit, njit_within
from jawenv.device.answer import add_brake, add_servos
from jawenv.estimation.aftermath import end_reading, look_ahead
from jawenv.estimation.contact_mean import be_unsure
from jawenv.estimation.ekf import mean_reading, move, set_muscles
from jawenv.estimation.held_teeth import follow_teeth
from jawenv.estimation.line_wrenches import middle_of, set_by_place, set_line_wrenches
from jawenv.estimation.measurement import N_MEASUREMENTS, expect
from jawenv.estimation.noisy_input import (
    limit_tremble,
    noisy_input_fields,
    predict_tremble,
    set_spilt,
    update_tremble,
)
from jawenv.estimation.posterior import posterior_fields
from jawenv.estimation.products import multiply, transpose
from jawenv.estimation.sensitivity import N_NOISE, sensitivity_fields
from jawenv.estimation.tension_belief import tension_count
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.kinematics import rotation
from jawenv.mechanics.vec3 import vector3


def tension_fields(n_muscles: int, n_lines: int, n_states: int, n_nodes: int) -> list[Any]:
    """The filter's working memory as fields of a dtype."""
    size = tension_count(n_muscles, n_nodes)
    return [
        *sensitivity_fields(0, n_lines, n_states),
        *noisy_input_fields(n_states),
        ("muscles", "f8", (n_lines, 2)),
        ("start_motion", "f8", (n_states,)),
        ("reading", "f8", (N_WRENCH,)),
        ("by_place", "f8", (n_states // 2, 3)),
        ("answer", "f8", (N_WRENCH, n_states)),
        ("speeds", "f8", (n_states // 2,)),
        ("speeds_cov", "f8", (n_states // 2, n_states // 2)),
        ("kept", "f8", (n_lines,)),  # share of each line's change of strain that regressors have
        ("line_wrench", "f8", (N_WRENCH, size)),
        ("moved", "f8", (n_states, size)),
        ("moved_cov", "f8", (n_states, n_states)),
        ("turned", "f8", (n_states + 1 + N_NOISE, n_states)),
        ("rows", "f8", (N_MEASUREMENTS, n_states)),
        ("expected", "f8", (N_MEASUREMENTS,)),
        ("gain", "f8", (n_states,)),
        ("row", "f8", (size,)),
        ("by_tension_rows", "f8", (N_MEASUREMENTS, size)),
        ("change", "f8", (n_states,)),
        ("spare", "f8", (n_states,)),
        ("after", "f8", (n_muscles, n_nodes)),
        ("carried", "f8", (n_nodes, n_nodes)),
        ("posterior", np.dtype(posterior_fields(n_muscles, n_nodes), align=True)),
    ]


@njit_within
def predict_motion(jaw, belief, samples, dt, noise_variance, usual_variance, device, has_servo, scratch):
    """Time update over one step: motion, its covariance, and its derivative by the coefficients.

    ``samples`` (3, 6) are the load cell's at start, middle and end; ``noise_variance`` (12) is that of the wrench not
    known: constant over the step, unmodelled and load-cell noise together; and tilting, the load cell's noise alone;
    ``usual_variance`` (12) is the same where the load cell does not fail.
    ``device`` is a record of dtype ``DEVICE``; its motors' servos are asked for where ``has_servo``.
    """
    size = belief.motion.shape[0]
    set_muscles(jaw, belief.mode_mean, 0, scratch.muscles)
    for i in range(size):
        scratch.start_motion[i] = belief.motion[i]
    for k in range(N_WRENCH):
        scratch.reading[k] = belief.trend[k] if has_servo else mean_reading(samples, k)
    limit_tremble(belief.tremble, belief.motion_cov)
    be_unsure(belief.motion_cov, belief.tremble, noise_variance, scratch)
    if jaw.condyles != 2:
        follow_teeth(jaw, belief.motion, belief.motion_cov, belief.tooth_depths, dt, scratch)
    move(jaw, scratch.muscles, belief.motion, samples, scratch.reading, 0.0, dt, scratch)
    q, place = middle_of(jaw, scratch.start_motion, belief.motion)
    body_to_head = rotation(q)
    bend = set_by_place(jaw, q, body_to_head, scratch)
    predict_cov(belief, noise_variance, scratch)
    answers = set_answer(jaw, belief.motion, usual_variance, device, has_servo, body_to_head, scratch)
    predict_tremble(belief.tremble, belief.motion_cov, noise_variance, answers, dt, scratch)
    look_ahead(belief, scratch.total)
    set_spilt(belief.aftermath, noise_variance, not answers, belief.score, belief.information, scratch)
    if answers:
        for k in range(N_WRENCH):
            scratch.reading[k] = belief.trend[k]
    set_line_wrenches(jaw, belief, place, body_to_head, bend, dt, scratch)
    predict_by_tension(belief.by_tension, scratch)


@njit
def set_answer(jaw, motion, usual_variance, device, has_servo, body_to_head, scratch):
    """Into ``answer`` how the device's wrench falls as the jaw moves; False where it does not."""
    half = scratch.speeds.shape[0]
    mouthpiece = vector3(jaw.mouthpiece)
    for i in range(half):
        scratch.speeds[i] = 0.5 * (scratch.start_motion[half + i] + motion[half + i])
    scratch.answer[:, :] = 0.0
    if has_servo:
        add_servos(device, mouthpiece, scratch.by_place, body_to_head, scratch.answer)
    set_trembling(usual_variance, scratch)
    brakes = add_brake(
        device,
        mouthpiece,
        scratch.by_place,
        scratch.speeds,
        scratch.speeds_cov,
        scratch.reading,
        scratch.answer,
        scratch.spare,
    )
    return brakes or has_servo


@njit
def set_trembling(usual_variance, scratch):
    """Into ``speeds_cov`` (n / 2, n / 2) what the unmodelled wrench of a tick makes of the speeds until its end."""
    total, speeds_cov = scratch.total, scratch.speeds_cov
    half, wrench = speeds_cov.shape[0], total.shape[0] + 1
    speeds_cov[:, :] = 0.0
    for k in range(N_WRENCH):
        unmodelled = usual_variance[k] - usual_variance[N_WRENCH + k]
        for i in range(half):
            factor = total[half + i, wrench + k] * unmodelled
            for j in range(half):
                speeds_cov[i, j] += factor * total[half + j, wrench + k]


@njit
def predict_cov(belief, noise_variance, scratch):
    """P <- A P A^T + G W G^T; leaves A P in ``moved_cov``, and the step's derivative transposed in ``turned``."""
    total, turned, covariance = scratch.total, scratch.turned, belief.motion_cov
    size = covariance.shape[0]
    wrench = size + 1
    transpose(total, turned)
    multiply(total, covariance, scratch.moved_cov)
    multiply(scratch.moved_cov, turned, covariance)
    for i in range(size):
        for k in range(N_NOISE):
            factor = total[i, wrench + k] * noise_variance[k]
            for j in range(i + 1):
                covariance[i, j] += factor * turned[wrench + k, j]
        for j in range(i):
            covariance[j, i] = covariance[i, j]


@njit
def predict_by_tension(by_tension, scratch):
    """The motion's derivative by the coefficients at the end of the step: A times the last one, and G times wrench."""
    total, moved = scratch.total, scratch.moved
    size, columns = by_tension.shape
    multiply(total, by_tension, moved)
    for i in range(size):
        for k in range(N_WRENCH):
            factor = total[i, size + 1 + k]
            for j in range(columns):
                moved[i, j] += factor * scratch.line_wrench[k, j]
    for i in range(size):
        for j in range(columns):
            by_tension[i, j] = moved[i, j]


@njit_within
def update_motion(jaw, belief, measured, variances, used, scratch):
    """Measurement update: motion, covariance, derivative, and what the innovations say about the coefficients.

    Measurements have independent noise and are taken one by one, which equals the joint update to rounding: all are
    linearised at the predicted motion.
    """
    size, columns = belief.motion.shape[0], belief.by_tension.shape[1]
    expect(jaw, belief.motion, scratch.rows, scratch.expected)
    gain, change = scratch.gain, scratch.change
    covariance, by_tension = belief.motion_cov, belief.by_tension
    tremble, gains, weights = belief.tremble, scratch.gains, scratch.weights
    for k in range(size):
        change[k] = 0.0
    for i in range(N_MEASUREMENTS):
        weights[i] = 0.0
        row = scratch.by_tension_rows[i]
        for j in range(columns):
            row[j] = 0.0
        if not used[i]:
            continue
        h = scratch.rows[i]
        variance, innovation = variances[i], measured[i] - scratch.expected[i]
        for j in range(size):
            gain[j] = 0.0
        for k in range(size):
            factor = h[k]
            if factor == 0.0:
                continue
            innovation -= factor * change[k]
            for j in range(size):
                gain[j] += factor * covariance[k, j]
            for j in range(columns):
                row[j] += factor * by_tension[k, j]
        for k in range(size):
            variance += h[k] * gain[k]
        inverse = 1.0 / variance
        weights[i] = inverse
        belief.misfit += 0.5 * (innovation * innovation * inverse + log(variance))
        update_tremble(tremble, h, gain, inverse, scratch.spare)
        for k in range(size):
            factor = gain[k] * inverse
            gains[i, k] = factor
            change[k] += factor * innovation
            for j in range(size):
                covariance[k, j] -= (gain[k] * gain[j]) * inverse
            for j in range(columns):
                by_tension[k, j] -= factor * row[j]
        for k in range(columns):
            belief.score[k] += row[k] * inverse * innovation
    for k in range(size):
        belief.motion[k] += change[k]
    add_information(belief.information, scratch.by_tension_rows, weights)
    if used.any():
        end_reading(belief, scratch)


@njit
def add_information(information, rows, weights):
    """The lower half of ``information`` += sum of weight times row row^T; four rows in one pass."""
    for i in range(0, N_MEASUREMENTS, 4):
        wa, wb, wc, wd = weights[i], weights[i + 1], weights[i + 2], weights[i + 3]
        if wa == 0.0 and wb == 0.0 and wc == 0.0 and wd == 0.0:
            continue
        for k in range(rows.shape[1]):
            a, b, c, d = wa * rows[i, k], wb * rows[i + 1, k], wc * rows[i + 2, k], wd * rows[i + 3, k]
            for j in range(k + 1):
                information[k, j] += (a * rows[i, j] + b * rows[i + 1, j]) + (c * rows[i + 2, j] + d * rows[i + 3, j])
