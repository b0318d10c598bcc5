"""Metrics of the belief: information in nats, score at the truth, NEES, from one world's covariances.

All are over the log-parameters, 12 by default. Claimed and bound information are half the fall of the log-determinant;
the score is log N(truth; belief) minus log N(truth; prior), a proper score: its mean over patients is the information
that the belief really holds.
"""

from __future__ import annotations

import numpy as np

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
def refresh_information(world, settings, factor, whitened):
    """Set log-determinants, NEES and log score of ``world`` from its belief, bound and truth."""
    if settings.bound:
        world.log_det_bound = decompose_parameters(world.bound, world.belief.motion.shape[0], factor)
    world.log_det = decompose_parameters(world.belief.cov, 0, factor)
    for i in range(whitened.shape[0]):
        whitened[i] = world.log_parameters[i] - world.belief.mean[i]
    solve_lower(factor, whitened)
    nees = 0.0
    for i in range(whitened.shape[0]):
        nees += whitened[i] * whitened[i]
    world.nees = nees
    world.log_score = -0.5 * (nees + world.log_det)
