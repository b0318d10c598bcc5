"""From the information about tension coefficients to a belief about the natural-log parameters.

Given are the prior N(theta_0, P_0) and the record's log-likelihood in the coefficients c of ``tension_basis``,
quadratic with matrix Lambda and maximum where Lambda (c - c_nominal) = score. The posterior of theta is not normal,
since c(theta) is curved: where the data fix only sums of tensions, it is a thin curved ridge. The belief is the normal
one that *posterior linearisation* finds (Garcia-Fernandez, Svensson, Morelande & Sarkka 2015, IEEE Trans. Signal
Process. 63:5561): c is linearised in the mean square over the belief itself, and what that leaves,

    Omega_kl = 1/2 trace(H_k P H_l P)    (H_k second derivatives of c_k by theta, P the belief's covariance),

counts as an error of the linearisation that is the same in all data: Lambda becomes (Lambda^-1 + Omega)^-1. Along a
ridge the belief is so wide that Omega is not small, and the covariance holds the ridge's bend; where all parameters
are known well, Omega vanishes and what remains is Newton's method for the mode.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from jawenv.compiled import njit
from jawenv.estimation.tension_basis import expand_coefficients

LONGEST_STEP = 1.0  # prior sds that the mean moves by at once: beyond, no expansion holds
NEGLIGIBLE = 0.05  # of the information, that Omega takes away
CONVERGED = 0.3  # sds of the belief: what the next round would still move is of the order of its square


def posterior_fields(n_muscles: int, n_nodes: int) -> list[Any]:
    """Working memory of ``believe`` as fields of a dtype."""
    size, parameters = n_muscles * n_nodes, 2 * n_muscles
    return [
        ("coefficients", "f8", (n_muscles, n_nodes)),
        ("by_log", "f8", (n_muscles, n_nodes, 2)),
        ("by_log_twice", "f8", (n_muscles, n_nodes, 3)),
        ("omega", "f8", (size, size)),
        ("known", "f8", (size, size)),
        ("reached", "f8", (size, parameters + 1)),
        ("system", "f8", (size, size)),
        ("residual", "f8", (size,)),
        ("precision", "f8", (parameters, parameters)),
        ("spare", "f8", (parameters, parameters)),
        ("right", "f8", (parameters,)),
    ]


@njit
def without_gain(information, score, gain_variance, scratch):
    """Information and score about c alone: the load cell's gain error, the last entry, integrated out."""
    size = scratch.known.shape[0]
    weight = 1.0 / (information[size, size] + 1.0 / gain_variance) if gain_variance > 0.0 else 0.0
    for i in range(size):
        share = weight * information[size, i]
        for j in range(i + 1):
            value = information[i, j] - share * information[size, j]
            scratch.known[i, j] = value
            scratch.known[j, i] = value
        scratch.residual[i] = score[i] - share * score[size]


@njit
def set_omega(covariance, scratch):
    """Omega from the belief's covariance and the mean second derivatives."""
    twice = scratch.by_log_twice
    muscles, nodes = twice.shape[0], twice.shape[1]
    for i in range(muscles):
        for j in range(i + 1):
            a, b = covariance[2 * i, 2 * j], covariance[2 * i, 2 * j + 1]
            c, d = covariance[2 * i + 1, 2 * j], covariance[2 * i + 1, 2 * j + 1]
            for k in range(nodes):
                f, g, h = twice[i, k, 0], twice[i, k, 1], twice[i, k, 2]
                # P_ji H_k P_ij, symmetric.
                m00 = a * a * f + 2.0 * a * c * g + c * c * h
                m01 = a * b * f + (a * d + b * c) * g + c * d * h
                m11 = b * b * f + 2.0 * b * d * g + d * d * h
                for l in range(nodes):
                    value = 0.5 * m00 * twice[j, l, 0] + m01 * twice[j, l, 1] + 0.5 * m11 * twice[j, l, 2]
                    scratch.omega[i * nodes + k, j * nodes + l] = value
                    scratch.omega[j * nodes + l, i * nodes + k] = value


@njit
def set_reached(nominal, scratch):
    """Lambda times [derivative of c by theta, mean of c less ``nominal``], and the score's residual in the last column.

    With Omega: both are multiplied by (1 + Lambda Omega)^-1, in ``reached`` (mK, p + 1).
    """
    known, omega, reached, by_log = scratch.known, scratch.omega, scratch.reached, scratch.by_log
    muscles, nodes = by_log.shape[0], by_log.shape[1]
    size, last = known.shape[0], 2 * muscles
    lost = 0.0
    for a in range(size):
        value = scratch.residual[a]
        for i in range(muscles):
            first, second = 0.0, 0.0
            for k in range(nodes):
                factor = known[a, i * nodes + k]
                first += factor * by_log[i, k, 0]
                second += factor * by_log[i, k, 1]
                value -= factor * (scratch.coefficients[i, k] - nominal[i, k])
            reached[a, 2 * i], reached[a, 2 * i + 1] = first, second
        reached[a, last] = value
        for b in range(size):
            lost += known[a, b] * omega[a, b]
    if lost < NEGLIGIBLE:
        return
    system = scratch.system
    for a in range(size):
        for b in range(size):
            system[a, b] = 0.0
        system[a, a] = 1.0
        for k in range(size):
            factor = known[a, k]
            for b in range(size):
                system[a, b] += factor * omega[k, b]
    solve_general(system, reached)


@njit
def solve_general(matrix, right):
    """Gaussian elimination with partial pivoting; ``right`` receives the solution, ``matrix`` is destroyed."""
    size, columns = right.shape
    for pivot in range(size):
        largest = pivot
        for i in range(pivot + 1, size):
            if abs(matrix[i, pivot]) > abs(matrix[largest, pivot]):
                largest = i
        if largest != pivot:
            for j in range(size):
                matrix[pivot, j], matrix[largest, j] = matrix[largest, j], matrix[pivot, j]
            for j in range(columns):
                right[pivot, j], right[largest, j] = right[largest, j], right[pivot, j]
        for i in range(pivot + 1, size):
            factor = matrix[i, pivot] / matrix[pivot, pivot]
            for j in range(pivot + 1, size):
                matrix[i, j] -= factor * matrix[pivot, j]
            for j in range(columns):
                right[i, j] -= factor * right[pivot, j]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            factor = matrix[i, k]
            for j in range(columns):
                right[i, j] -= factor * right[k, j]
        for j in range(columns):
            right[i, j] /= matrix[i, i]


@njit
def set_precision(mean, prior_mean, prior_sd, scratch):
    """Precision of the linearised posterior, and in ``right`` the gradient of its logarithm at ``mean``."""
    by_log, reached, precision = scratch.by_log, scratch.reached, scratch.precision
    muscles, nodes = by_log.shape[0], by_log.shape[1]
    last = 2 * muscles
    for i in range(muscles):
        for r in range(2):
            row, value = 2 * i + r, 0.0
            for column in range(last):
                precision[row, column] = 0.0
            for k in range(nodes):
                factor = by_log[i, k, r]
                value += factor * reached[i * nodes + k, last]
                for column in range(last):
                    precision[row, column] += factor * reached[i * nodes + k, column]
            scratch.right[row] = value + (prior_mean[row] - mean[row]) / (prior_sd[row] * prior_sd[row])
    for row in range(last):
        for column in range(row):
            value = 0.5 * (precision[row, column] + precision[column, row])
            precision[row, column], precision[column, row] = value, value
        precision[row, row] += 1.0 / (prior_sd[row] * prior_sd[row])


@njit
def invert_positive(matrix, inverse):
    """Inverse of a symmetric positive definite matrix; False if it is not positive definite.

    The lower half of ``matrix`` is overwritten by the inverse of its Cholesky factor.
    """
    size = matrix.shape[0]
    for j in range(size):
        for i in range(j, size):
            value = matrix[i, j]
            for k in range(j):
                value -= matrix[i, k] * matrix[j, k]
            if i == j:
                if not value > 0.0:
                    return False
                matrix[j, j] = sqrt(value)
            else:
                matrix[i, j] = value / matrix[j, j]
    for j in range(size):
        matrix[j, j] = 1.0 / matrix[j, j]
        for i in range(j + 1, size):
            value = 0.0
            for k in range(j, i):
                value -= matrix[i, k] * matrix[k, j]
            matrix[i, j] = value / matrix[i, i]
    for i in range(size):
        for j in range(i + 1):
            value = 0.0
            for k in range(i, size):
                value += matrix[k, i] * matrix[k, j]
            inverse[i, j] = value
            inverse[j, i] = value
    return True


@njit
def believe(basis, information, score, nominal, gain_variance, prior_mean, prior_sd, mean, covariance, scratch, rounds):
    """Refine the belief ``mean`` (p), ``covariance`` (p, p) by at most ``rounds`` rounds; True when it has converged.

    ``information`` (mK + 1, mK + 1) and ``score`` (mK + 1) are about c and the gain error, the score at ``nominal``
    (m, K). The belief given is where the search starts: the last one, or the prior.
    """
    parameters = mean.shape[0]
    for _ in range(rounds):
        without_gain(information, score, gain_variance, scratch)
        expand_coefficients(basis, mean, covariance, scratch.coefficients, scratch.by_log, scratch.by_log_twice)
        set_omega(covariance, scratch)
        set_reached(nominal, scratch)
        set_precision(mean, prior_mean, prior_sd, scratch)
        if not invert_positive(scratch.precision, covariance):
            # Where Omega dwarfs all else rounding decides: the belief stays, if the information itself is sound.
            scratch.omega[:, :] = 0.0
            set_reached(nominal, scratch)
            set_precision(mean, prior_mean, prior_sd, scratch)
            if not invert_positive(scratch.precision, scratch.spare):
                for i in range(parameters):
                    covariance[i, i] = np.nan
            return False
        furthest, longest = 0.0, 0.0
        for i in range(parameters):
            step = 0.0
            for j in range(parameters):
                step += covariance[i, j] * scratch.right[j]
            scratch.precision[i, 0] = step
            furthest = max(furthest, abs(step) / prior_sd[i])
            longest = max(longest, abs(step) / sqrt(covariance[i, i]))
        share = min(1.0, LONGEST_STEP / furthest) if furthest > 0.0 else 1.0
        for i in range(parameters):
            mean[i] += share * scratch.precision[i, 0]
        if longest < CONVERGED:
            return True
    return False
