"""Metrics of the belief: information in nats, score at the truth, NEES, from one world's covariances.

All are over the log-parameters, 12 by default. Claimed and bound information are half the fall of the log-determinant;
the score is log N(truth; belief) minus log N(truth; prior), a proper score: its mean over patients is the information
that the belief really holds.
"""

from __future__ import annotations

from math import log, sqrt

import numpy as np

from jawenv.kernels.compiled import njit


@njit
def cholesky_parameters(covariance, first, lower):
    """Cholesky factor of the parameters' block, which begins at ``first``; its log-determinant, NaN if not PD."""
    log_det = 0.0
    size = lower.shape[0]
    for j in range(size):
        pivot = covariance[first + j, first + j]
        for k in range(j):
            pivot -= lower[j, k] * lower[j, k]
        if not pivot > 0.0:
            return np.nan
        root = sqrt(pivot)
        lower[j, j] = root
        log_det += 2.0 * log(root)
        for i in range(j + 1, size):
            value = covariance[first + i, first + j]
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            lower[i, j] = value / root
    return log_det


@njit
def refresh_information(world, lower, whitened):
    """Set log-determinant, NEES and log score of ``world`` from its belief and truth."""
    truth, known = world.truth, world.known
    known.log_det = cholesky_parameters(known.belief.cov, 0, lower)
    nees = 0.0
    for i in range(whitened.shape[0]):
        value = truth.log_parameters[i] - known.belief.mean[i]
        for k in range(i):
            value -= lower[i, k] * whitened[k]
        whitened[i] = value / lower[i, i]
        nees += whitened[i] * whitened[i]
    truth.nees = nees
    truth.log_score = -0.5 * (nees + known.log_det)
