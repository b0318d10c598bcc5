"""The online filter: motion filtered at the present estimate, information about the muscles gathered beside it.

Three things are carried from tick to tick (Friedland 1969, IEEE Trans. Autom. Control 14:359, the bias-separated form
of the Kalman filter):

* the motion (q, u) and its covariance, as if the muscles were known to be what the belief's mean says;
* ``by_tension``, by how much that motion would differ if the muscles were others: its derivative by the coefficients c
  of ``tension_basis`` and by the load cell's gain error;
* the information that the innovations hold about those: matrix and score of a quadratic log-likelihood.

Forces are linear in c, so that the information of early data, gathered about a poor guess, holds as well as that of
late data. No noise has to be put on the parameters, which are constants. The belief about the natural-log parameters is
made from the information and the prior (``posterior``); the motion is then moved to the new mean (``recentre``).

The force on the jaw is the reading plus g times the recent trend of readings: a reading that multiplied g would let the
filter take the load cell's noise for a force without effect. What g makes of the readings' departure from their trend
is too fast to correlate: it adds to the process noise.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.compiled import njit
from jawenv.estimation.ekf import move, set_muscles, set_wrench_variance
from jawenv.estimation.measurement import N_MEASUREMENTS, expect
from jawenv.estimation.posterior import believe, posterior_fields
from jawenv.estimation.sensitivity import sensitivity_fields
from jawenv.estimation.tension_basis import set_coefficients
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.kinematics import contact_point, rotation
from jawenv.mechanics.vec3 import add, apply, apply_transposed, cross, norm, row3, scale, subtract, vector3

# Ticks at the start after each of which the belief is renewed: its first guess is far off.
EAGER_TICKS = 20
ROUNDS = 3  # at most, of the search for the belief at the end of a control period


def tension_count(n_muscles: int, n_nodes: int) -> int:
    """Number of what information is gathered about: the coefficients and the gain error."""
    return n_muscles * n_nodes + 1


def belief_fields(n_muscles: int, n_states: int, n_nodes: int) -> list[Any]:
    """What the filter carries from tick to tick, as fields of a dtype."""
    size, parameters = tension_count(n_muscles, n_nodes), 2 * n_muscles
    return [
        ("motion", "f8", (n_states,)),
        ("motion_cov", "f8", (n_states, n_states)),
        ("by_tension", "f8", (n_states, size)),
        ("information", "f8", (size, size)),
        ("score", "f8", (size,)),
        ("nominal", "f8", (n_muscles, n_nodes)),
        ("belief_mean", "f8", (parameters,)),
        ("belief_cov", "f8", (parameters, parameters)),
        ("trend", "f8", (N_WRENCH,)),
    ]


def tension_scratch_dtype(n_muscles: int, n_lines: int, n_states: int, n_nodes: int) -> np.dtype[np.void]:
    """Dtype of the filter's working memory."""
    size = tension_count(n_muscles, n_nodes)
    fields = [
        *sensitivity_fields(0, n_lines, n_states),
        ("muscles", "f8", (n_lines, 2)),
        ("start_motion", "f8", (n_states,)),
        ("wrench_variance", "f8", (N_WRENCH,)),
        ("line_wrench", "f8", (N_WRENCH, size)),
        ("moved", "f8", (n_states, size)),
        ("moved_cov", "f8", (n_states, n_states)),
        ("rows", "f8", (N_MEASUREMENTS, n_states)),
        ("expected", "f8", (N_MEASUREMENTS,)),
        ("gain", "f8", (n_states,)),
        ("row", "f8", (size,)),
        ("change", "f8", (n_states,)),
        ("after", "f8", (n_muscles, n_nodes)),
        ("posterior", np.dtype(posterior_fields(n_muscles, n_nodes), align=True)),
    ]
    return np.dtype(fields, align=True)


@njit
def middle_of(jaw, before, after):
    """Place of the body's reference point and rotation half way between two states."""
    if jaw.condyles == 2:
        place = (0.5 * (before[0] + after[0]), 0.5 * (before[1] + after[1]), 0.5 * (before[2] + after[2]))
        q = (
            0.5 * (before[0] + after[0]),
            0.5 * (before[1] + after[1]),
            0.5 * (before[3] + after[3]),
            0.5 * (before[4] + after[4]),
            0.5 * (before[5] + after[5]),
        )
        return place, rotation(q)
    q = (
        0.5 * (before[0] + after[0]),
        0.5 * (before[1] + after[1]),
        0.5 * (before[2] + after[2]),
        0.5 * (before[3] + after[3]),
        0.5 * (before[4] + after[4]),
    )
    return contact_point(jaw, q), rotation(q)


@njit
def set_line_wrenches(jaw, basis, before, after, trend, line_wrench):
    """Wrench at the mouthpiece (body axes) that each coefficient of unit size amounts to, and the gain error's.

    Lines are taken half way through the step.
    """
    place, body_to_head = middle_of(jaw, before, after)
    nodes = basis.nodes.shape[1]
    for k in range(N_WRENCH):
        for j in range(line_wrench.shape[1]):
            line_wrench[k, j] = 0.0
        line_wrench[k, line_wrench.shape[1] - 1] = trend[k]
    mouthpiece = vector3(jaw.mouthpiece)
    for line in range(jaw.origin.shape[0]):
        insertion = row3(jaw.insertion, line)
        reach = subtract(row3(jaw.origin, line), add(place, apply(body_to_head, insertion)))
        length = norm(reach)
        pull = apply_transposed(body_to_head, scale(1.0 / length, reach))
        turn = cross(subtract(insertion, mouthpiece), pull)
        muscle = jaw.muscle[line]
        strain = length / jaw.l_o[line] - 1.0 - basis.centre[muscle]
        for k in range(nodes):
            share = np.exp(basis.nodes[muscle, k] * strain)
            column = muscle * nodes + k
            for i in range(3):
                line_wrench[i, column] += share * pull[i]
                line_wrench[3 + i, column] += share * turn[i]


@njit
def predict_motion(jaw, basis, belief, samples, dt, wrench_variance, gain_variance, scratch):
    """Time update over one step: motion, its covariance, and its derivative by the coefficients.

    ``samples`` (3, 6) are the load cell's at start, middle and end; ``wrench_variance`` (6) is that of the wrench not
    known: unmodelled and load-cell noise together.
    """
    size, columns = belief.motion.shape[0], belief.by_tension.shape[1]
    set_muscles(jaw, belief.belief_mean, 0, scratch.muscles)
    for i in range(size):
        scratch.start_motion[i] = belief.motion[i]
    move(jaw, scratch.muscles, belief.motion, samples, belief.trend, 0.0, dt, scratch)
    set_line_wrenches(jaw, basis, scratch.start_motion, belief.motion, belief.trend, scratch.line_wrench)
    set_wrench_variance(wrench_variance, gain_variance, samples, belief.trend, scratch)
    total, moved, moved_cov = scratch.total, scratch.moved, scratch.moved_cov
    wrench = size + 1
    for i in range(size):
        for j in range(columns):
            moved[i, j] = 0.0
        for k in range(size):
            factor = total[i, k]
            for j in range(columns):
                moved[i, j] += factor * belief.by_tension[k, j]
        for k in range(N_WRENCH):
            factor = total[i, wrench + k]
            for j in range(columns):
                moved[i, j] += factor * scratch.line_wrench[k, j]
        for j in range(size):
            moved_cov[i, j] = 0.0
        for k in range(size):
            factor = total[i, k]
            for j in range(size):
                moved_cov[i, j] += factor * belief.motion_cov[k, j]
    for i in range(size):
        for j in range(columns):
            belief.by_tension[i, j] = moved[i, j]
        for j in range(i + 1):
            value = 0.0
            for k in range(size):
                value += moved_cov[i, k] * total[j, k]
            for k in range(N_WRENCH):
                value += total[i, wrench + k] * scratch.wrench_variance[k] * total[j, wrench + k]
            belief.motion_cov[i, j] = value
            belief.motion_cov[j, i] = value


@njit
def update_motion(jaw, belief, measured, variances, used, scratch):
    """Measurement update: motion, covariance, derivative, and what the innovations say about the coefficients.

    Measurements have independent noise and are taken one by one, which equals the joint update to rounding: all are
    linearised at the predicted motion.
    """
    size, columns = belief.motion.shape[0], belief.by_tension.shape[1]
    expect(jaw, belief.motion, scratch.rows, scratch.expected)
    gain, row, change = scratch.gain, scratch.row, scratch.change
    covariance, by_tension, information = belief.motion_cov, belief.by_tension, belief.information
    for k in range(size):
        change[k] = 0.0
    for i in range(N_MEASUREMENTS):
        if not used[i]:
            continue
        h = scratch.rows[i]
        variance, innovation = variances[i], measured[i] - scratch.expected[i]
        for j in range(size):
            gain[j] = 0.0
        for j in range(columns):
            row[j] = 0.0
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
        for k in range(size):
            factor = gain[k] * inverse
            change[k] += factor * innovation
            for j in range(size):
                covariance[k, j] -= (gain[k] * gain[j]) * inverse
            for j in range(columns):
                by_tension[k, j] -= factor * row[j]
        for k in range(columns):
            factor = row[k] * inverse
            belief.score[k] += factor * innovation
            for j in range(k + 1):
                information[k, j] += factor * row[j]
    for k in range(size):
        belief.motion[k] += change[k]


@njit
def recentre(basis, belief, scratch):
    """Move motion and score to the belief's mean."""
    size, columns = belief.motion.shape[0], belief.by_tension.shape[1]
    nodes = basis.nodes.shape[1]
    set_coefficients(basis, belief.belief_mean, scratch.after)
    row = scratch.row
    for j in range(columns - 1):
        row[j] = scratch.after[j // nodes, j % nodes] - belief.nominal[j // nodes, j % nodes]
    row[columns - 1] = 0.0
    for i in range(size):
        for j in range(columns):
            belief.motion[i] += belief.by_tension[i, j] * row[j]
    information = belief.information
    for i in range(columns):
        for j in range(columns):
            belief.score[i] -= (information[i, j] if j <= i else information[j, i]) * row[j]
    for j in range(columns - 1):
        belief.nominal[j // nodes, j % nodes] = scratch.after[j // nodes, j % nodes]


@njit
def begin_belief(basis, belief, prior_mean, prior_sd):
    """The prior, before any measurement; ``motion`` and ``motion_cov`` are the caller's to set."""
    for i in range(prior_mean.shape[0]):
        belief.belief_mean[i] = prior_mean[i]
        for j in range(prior_mean.shape[0]):
            belief.belief_cov[i, j] = 0.0
        belief.belief_cov[i, i] = prior_sd[i] * prior_sd[i]
    belief.by_tension[:, :] = 0.0
    belief.information[:, :] = 0.0
    belief.score[:] = 0.0
    belief.trend[:] = 0.0
    set_coefficients(basis, belief.belief_mean, belief.nominal)


@njit
def conclude(basis, belief, prior_mean, prior_sd, gain_variance, scratch, rounds):
    """The belief about the parameters from all information so far; motion and score move to its mean."""
    believe(
        basis,
        belief.information,
        belief.score,
        belief.nominal,
        gain_variance,
        prior_mean,
        prior_sd,
        belief.belief_mean,
        belief.belief_cov,
        scratch.posterior,
        rounds,
    )
    recentre(basis, belief, scratch)
