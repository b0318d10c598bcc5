"""The belief about the natural-log parameters, made from the information about tension coefficients.

Given are the prior N(theta_0, P_0) and the record's log-likelihood in the coefficients c of ``basis``,
quadratic with matrix Lambda and maximum where Lambda (c - c_nominal) = score. The posterior of theta is not normal,
since c(theta) is curved: where the data fix only sums of tensions, it is a thin curved ridge. The belief is the normal
one that *posterior linearisation* finds (Garcia-Fernandez, Svensson, Morelande & Sarkka 2015, IEEE Trans. Signal
Process. 63:5561): c is linearised by statistical regression over the belief itself, and the residual covariance,

    Omega_kl = 1/2 trace(H_k P H_l P)    (H_k second derivatives of c_k by theta, P the belief's covariance),

is a linearisation error common to all data: Lambda becomes (Lambda^-1 + Omega)^-1. Along a ridge the belief is wide,
Omega is not small, and the covariance includes the ridge's curvature; where all parameters are known well, Omega
vanishes and the iteration is Newton's method for the mode.
"""

from __future__ import annotations

from functools import cache
from math import isfinite
from typing import Annotated

import numpy as np

from jawenv.filter.belief.state import Belief, FilterSettings, shared_columns
from jawenv.filter.model.basis import N_NODES, expand_coefficients
from jawenv.filter.model.motion_step import padded
from jawenv.kernels.cholesky import invert_positive, set_root
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import add_squares, decompose, mirror, whiten
from jawenv.kernels.records import Array, record_dtype

LONGEST_STEP = 1.0  # prior sds, largest step of the mean at once: the trust region of the expansion
NEGLIGIBLE = 0.05  # relative loss of information by Omega below which Omega is neglected


class PosteriorScratch:
    """Working memory of ``update_belief``."""

    shared: Annotated[Array, "shared", "wide"]  # information of gain error and nuisances with c; score; zeros
    explained: Annotated[Array, "wide", "wide"]  # upper half
    pulled_nuisances: Annotated[Array, "shared"]
    coefficients: Annotated[Array, "muscles", N_NODES]
    by_log_twice: Annotated[Array, "muscles", N_NODES, 3]
    marginal: Annotated[Array, "size", "size"]
    unexplained: Annotated[Array, "size"]
    residual: Annotated[Array, "size"]
    spread: Annotated[Array, "size", "bends"]
    bent: Annotated[Array, "bends", "bends"]
    root: Annotated[Array, "bends", "bends"]
    omega: Annotated[Array, "bends", "bends"]
    system: Annotated[Array, "bends", "bends"]
    pulled: Annotated[Array, "bends"]
    reached: Annotated[Array, "bends", "pulls"]
    precision: Annotated[Array, "parameters", "parameters"]
    right: Annotated[Array, "parameters"]
    last_mean: Annotated[Array, "parameters"]
    last_cov: Annotated[Array, "parameters", "parameters"]


@cache
def posterior_dtype(n_muscles: int, n_nuisances: int = 0) -> np.dtype[np.void]:
    """Dtype of ``PosteriorScratch``."""
    size, parameters, bends = n_muscles * N_NODES, 2 * n_muscles, 3 * n_muscles
    wide = padded(size + 1)
    return record_dtype(
        PosteriorScratch,
        shared=shared_columns(n_nuisances),
        wide=wide,
        muscles=n_muscles,
        size=size,
        bends=bends,
        pulls=parameters + 1,
        parameters=parameters,
    )


@njit
def _without_nuisances(belief: Belief, gain_variance, scratch: PosteriorScratch):
    """Information and score about c alone: gain error and nuisances integrated out, with their priors.

    Leaves the factor of their information at given c in ``nuisance_factor``. False if that has none.
    """
    information, score, factor, shared = belief.information, belief.score, belief.nuisance_factor, scratch.shared
    first, number = scratch.marginal.shape[0], factor.shape[0]
    gains = number - belief.nuisances.shape[0]
    for i in range(number):
        for j in range(i + 1):
            factor[i, j] = information[first + i, first + j]
        factor[i, i] += 1.0 if i >= gains else (1.0 / gain_variance if gain_variance > 0.0 else 0.0)
        for j in range(first):
            shared[i, j] = information[first + i, j]
        shared[i, first] = score[first + i] - (belief.nuisances[i - gains] if i >= gains else 0.0)
    if not gain_variance > 0.0:
        for k in range(gains):
            shared[k, :] = 0.0
            for i in range(number):
                factor[i, k] = 0.0
            factor[k, k] = 1.0
    if not decompose(factor):
        return False
    whiten(factor, shared)
    scratch.explained[:, :] = 0.0
    add_squares(shared, scratch.explained)
    for i in range(first):
        for j in range(i + 1):
            value = information[i, j] - scratch.explained[j, i]
            scratch.marginal[i, j] = value
            scratch.marginal[j, i] = value
        scratch.unexplained[i] = score[i] - scratch.explained[i, first]
    return True


@njit
def set_bent(nominal, scratch: PosteriorScratch):
    """N = T^T Lambda T into ``bent`` (3 m, 3 m), and T^T (score - Lambda (mean c - nominal)) into ``pulled`` (3 m).

    T (m K, 3 m) holds the second derivatives of each muscle's c: by log F_o twice, by both, by log b twice. The first
    two are the first derivatives too, as c is proportional to F_o.
    """
    marginal, spread, second_derivatives, bent = scratch.marginal, scratch.spread, scratch.by_log_twice, scratch.bent
    muscles, nodes = second_derivatives.shape[0], second_derivatives.shape[1]
    for a in range(marginal.shape[0]):
        value = scratch.unexplained[a]
        for i in range(muscles):
            first, second, third = 0.0, 0.0, 0.0
            for k in range(nodes):
                factor = marginal[a, i * nodes + k]
                first += factor * second_derivatives[i, k, 0]
                second += factor * second_derivatives[i, k, 1]
                third += factor * second_derivatives[i, k, 2]
                value -= factor * (scratch.coefficients[i, k] - nominal[i, k])
            spread[a, 3 * i], spread[a, 3 * i + 1], spread[a, 3 * i + 2] = first, second, third
        scratch.residual[a] = value
    for i in range(muscles):
        for r in range(3):
            row, value = 3 * i + r, 0.0
            for column in range(bent.shape[0]):
                bent[row, column] = 0.0
            for k in range(nodes):
                factor = second_derivatives[i, k, r]
                value += factor * scratch.residual[i * nodes + k]
                for column in range(bent.shape[0]):
                    bent[row, column] += factor * spread[i * nodes + k, column]
            scratch.pulled[row] = value


@njit
def set_omega(covariance, omega):
    """Omega = T G T^T: G into ``omega`` (3 m, 3 m), from the belief's covariance."""
    for i in range(omega.shape[0] // 3):
        for j in range(i + 1):
            a, b = covariance[2 * i, 2 * j], covariance[2 * i, 2 * j + 1]
            c, d = covariance[2 * i + 1, 2 * j], covariance[2 * i + 1, 2 * j + 1]
            block = (
                (0.5 * a * a, a * b, 0.5 * b * b),
                (a * c, a * d + b * c, b * d),
                (0.5 * c * c, c * d, 0.5 * d * d),
            )
            for r in range(3):
                for s in range(3):
                    omega[3 * i + r, 3 * j + s] = block[r][s]
                    omega[3 * j + s, 3 * i + r] = block[r][s]


@njit
def _set_reached(scratch: PosteriorScratch):
    """Y with Y^T Y = E^T (N^-1 + G)^-1 E into ``reached`` (3 m, p), where E picks the first derivatives of T.

    With N = C C^T and 1 + C^T G C = M M^T: Y = M^-1 C^T E, positive semidefinite whatever rounding does. The last
    column receives what of ``pulled`` is left, (1 + N G)^-1 of it. False if M does not exist.
    """
    root, omega, system, reached = scratch.root, scratch.omega, scratch.system, scratch.reached
    size, last = root.shape[0], reached.shape[1] - 1
    set_root(scratch.bent, root)
    for i in range(size):
        for j in range(size):
            scratch.spread[i, j] = 0.0
        for k in range(size):
            factor = omega[i, k]
            for j in range(k + 1):
                scratch.spread[i, j] += factor * root[k, j]
    for i in range(size):
        for j in range(size):
            system[i, j] = 1.0 if i == j else 0.0
    for k in range(size):
        for i in range(k + 1):
            factor = root[k, i]
            for j in range(i + 1):
                system[i, j] += factor * scratch.spread[k, j]
    if not decompose(system):
        return False
    for k in range(size):
        for i in range(last // 2):
            reached[k, 2 * i], reached[k, 2 * i + 1] = root[3 * i, k], root[3 * i + 1, k]
        value = 0.0
        for i in range(size):
            value += scratch.spread[i, k] * scratch.pulled[i]
        reached[k, last] = value
    whiten(system, reached)
    return True


@njit
def set_precision(mean, prior_mean, prior_sd, scratch: PosteriorScratch):
    """Precision of the linearised posterior, and in ``right`` the gradient of its logarithm at ``mean``.

    False where rounding leaves no answer.
    """
    bent, omega, reached, precision, right = (
        scratch.bent,
        scratch.omega,
        scratch.reached,
        scratch.precision,
        scratch.right,
    )
    parameters = mean.shape[0]
    information_loss = 0.0
    for i in range(bent.shape[0]):
        for j in range(bent.shape[0]):
            information_loss += bent[i, j] * omega[i, j]
    for i in range(parameters):
        row = 3 * (i // 2) + i % 2
        for j in range(parameters):
            precision[i, j] = bent[row, 3 * (j // 2) + j % 2]
        right[i] = scratch.pulled[row]
    if not information_loss < NEGLIGIBLE:
        if not _set_reached(scratch):
            return False
        for i in range(parameters):
            for j in range(parameters):
                precision[i, j] = 0.0
        for k in range(bent.shape[0]):
            for i in range(parameters):
                factor = reached[k, i]
                right[i] -= factor * reached[k, parameters]
                for j in range(parameters):
                    precision[i, j] += factor * reached[k, j]
    for i in range(parameters):
        weight = 1.0 / (prior_sd[i] * prior_sd[i])
        precision[i, i] += weight
        right[i] += weight * (prior_mean[i] - mean[i])
    return True


@njit
def update_belief(belief: Belief, settings: FilterSettings, scratch: PosteriorScratch):
    """Refine the belief about the parameters by one step of the iteration; False where there is no answer.

    Information and score are those gathered so far, the score at ``belief.nominal``. One step is enough, since there is
    one after every few readings, and each starts at the last belief. That stays where rounding or an overflow leaves no
    answer.

    Args:
        belief: See ``state.belief_dtype``; its mean (p) and cov (p, p) change.
        settings: See ``FilterSettings``.
        scratch: Record of dtype ``posterior_dtype``.
    """
    mean, covariance = belief.mean, belief.cov
    mirror(belief.information)
    scratch.last_mean[:] = mean
    scratch.last_cov[:, :] = covariance
    if _without_nuisances(belief, settings.gain_variance, scratch) and refine(belief, settings, scratch):
        return True
    mean[:] = scratch.last_mean
    covariance[:, :] = scratch.last_cov
    return False


@njit
def refine(belief: Belief, settings: FilterSettings, scratch: PosteriorScratch):
    """One step of the iteration, within the trust region; False where there is none."""
    mean, covariance, prior_sd = belief.mean, belief.cov, settings.prior_sd
    parameters = mean.shape[0]
    expand_coefficients(belief.basis, mean, covariance, scratch.coefficients, scratch.by_log_twice)
    set_bent(belief.nominal, scratch)
    set_omega(covariance, scratch.omega)
    if not set_precision(mean, settings.prior_mean, prior_sd, scratch):
        return False
    if not invert_positive(scratch.precision, covariance):
        return False
    furthest, total = 0.0, 0.0
    for i in range(parameters):
        step = 0.0
        for j in range(parameters):
            step += covariance[i, j] * scratch.right[j]
        scratch.precision[i, 0] = step
        furthest = max(furthest, abs(step) / prior_sd[i])
        total += step
    share = min(1.0, LONGEST_STEP / furthest) if furthest > 0.0 else 1.0
    for i in range(parameters):
        mean[i] += share * scratch.precision[i, 0]
    return isfinite(total)
