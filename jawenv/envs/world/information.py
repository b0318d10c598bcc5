"""Metrics of the belief: information in nats, score at the truth, NEES, from one world's covariances.

All are over the log-parameters, 12 by default. Claimed and bound information are half the fall of the log-determinant;
the score is log N(truth; belief) minus log N(truth; prior), a proper score: its mean over patients is the information
that the belief really holds.
"""

from __future__ import annotations

import numpy as np

from jawenv.envs.world.record import World
from jawenv.kernels.cholesky import log_det, solve_lower
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import decompose


@njit
def decompose_parameters(covariance, first, factor):
    """Cholesky factor of the parameters' block, which begins at ``first``; its log-determinant, NaN if not PD."""
    size = factor.shape[0]
    for i in range(size):
        for j in range(i + 1):
            factor[i, j] = covariance[first + i, first + j]
    return log_det(factor) if decompose(factor) else np.nan


@njit
def refresh_information(world: World, factor, whitened):
    """Set log-determinant, NEES and log score of ``world`` from its belief and truth."""
    truth, known = world.truth, world.known
    known.log_det = decompose_parameters(known.belief.cov, 0, factor)
    for i in range(whitened.shape[0]):
        whitened[i] = truth.log_parameters[i] - known.belief.mean[i]
    solve_lower(factor, whitened)
    nees = 0.0
    for i in range(whitened.shape[0]):
        nees += whitened[i] * whitened[i]
    truth.nees = nees
    truth.log_score = -0.5 * (nees + known.log_det)
