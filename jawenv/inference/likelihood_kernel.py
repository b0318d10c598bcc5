"""The log-likelihood of one record at given parameters, in one compiled call.

The state is motion, p log-parameters and the load cell's gain error, as in ``joint_recursion``. The parameters have no
variance, so that they stay as they are. The gain error is estimated, as innovations are white only then.
"""

from __future__ import annotations

from math import log, pi

import numpy as np

from jawenv.filter.bound.joint_recursion import JointScratch, innovation_variance
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.readings.cell_trend import follow_trend
from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.references.extended_kalman_kernel import Problem, predict_plain


@njit
def take_readings(problem: Problem, tick, mean, covariance, scratch: JointScratch):
    """Measurement update with the encoders' readings of a time; returns the log-density of their innovations."""
    size = mean.shape[0]
    measure(problem.jaw, mean, scratch.rows, scratch.expected)
    for j in range(size):
        scratch.shift[j] = 0.0
    density = 0.0
    for i in range(N_MEASUREMENTS):
        reading = problem.measured[tick, i]
        if reading != reading:  # not read
            continue
        row = scratch.rows[i]
        variance = innovation_variance(covariance, row, problem.variances[i], scratch.gain)
        innovation = reading - scratch.expected[i]
        for k in range(row.shape[0]):
            innovation -= row[k] * scratch.shift[k]
        density -= 0.5 * (log(2.0 * pi * variance) + innovation * innovation / variance)
        for j in range(size):
            scratch.shift[j] += innovation / variance * scratch.gain[j]
            for k in range(size):
                covariance[j, k] -= (scratch.gain[j] * scratch.gain[k]) / variance
    for j in range(size):
        mean[j] += scratch.shift[j]
    return density


@njit
def innovations_log_density(problem: Problem, mean, covariance, scratch: JointScratch):
    """Log-density of all readings of the encoders.

    Args:
        problem: ``extended_kalman_kernel.Problem``.
        mean: (n + p + 1,) before the first reading; changed.
        covariance: (n + p + 1, n + p + 1) likewise, 0 for the parameters; changed.
        scratch: Working memory.
    """
    trend = np.zeros(N_WRENCH)
    density = take_readings(problem, 0, mean, covariance, scratch)
    for tick in range(problem.samples.shape[0]):
        predict_plain(problem, tick, mean, covariance, trend, scratch)
        follow_trend(trend, problem.samples[tick], problem.dt)
        density += take_readings(problem, tick + 1, mean, covariance, scratch)
    return density
