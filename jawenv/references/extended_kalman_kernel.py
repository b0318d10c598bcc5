"""The plain extended Kalman filter over a whole record in one compiled call.

State and covariance recursion are those of ``joint_recursion``. The parameters are natural logs, or with ``linear`` F_o
and b themselves.
"""

from __future__ import annotations

from math import log
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.bound.joint_recursion import (
    JointScratch,
    innovation_variance,
    predict_covariance,
    set_noise_variance,
)
from jawenv.filter.bound.joint_step import propagate
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.model.motion_step import set_muscles
from jawenv.filter.readings.cell_trend import follow_trend
from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw

Array = NDArray[np.float64]


class Problem(NamedTuple):
    """A record of T ticks and how its p parameters are filtered; all that the kernels only read."""

    jaw: Any  # record of dtype ``jaw_dtype``
    measured: Array  # (T + 1, 12); NaN was not read
    samples: Array  # (T, 3, 6) of the load cell
    dt: float  # s
    variances: Array  # (12,) of the encoders
    noise_variance: Array  # (12,) of the wrench not known, constant over a tick and tilting
    parameter_noise: Array  # (T, p) variance that the parameters receive in each tick
    linear: bool  # whether the parameters are F_o and b themselves
    floor: Array  # (p,) least value of a linear parameter: a muscle has no negative tension


@njit
def reduce_covariance(covariance, gain, variance):
    """Covariance after a measurement whose innovation has this variance; that of the load cell's gain stays."""
    size = gain.shape[0]
    inverse = 1.0 / variance
    considered = covariance[size - 1, size - 1]
    for i in range(size):
        for j in range(size):
            # The product first: it is the same number for (i, j) and (j, i), so P stays symmetric to the bit.
            covariance[i, j] -= (gain[i] * gain[j]) * inverse
    covariance[size - 1, size - 1] = considered


@njit
def predict_plain(problem: Problem, tick, mean, covariance, trend, scratch: JointScratch):
    """Time update over one tick."""
    linear, floor, samples = problem.linear, problem.floor, problem.samples[tick]
    gain, first = mean.shape[0] - 1, scratch.total.shape[0]
    logs = np.empty(floor.shape[0])
    for j in range(logs.shape[0]):
        logs[j] = log(max(mean[first + j], floor[j])) if linear else mean[first + j]
    set_muscles(problem.jaw, logs, scratch.muscles)
    propagate(problem.jaw, scratch.muscles, mean, samples, trend, mean[gain], problem.dt, scratch)
    if linear:
        for j in range(logs.shape[0]):
            by_log = 1.0 / max(mean[first + j], floor[j])
            for i in range(first):
                scratch.total[i, first + j] *= by_log
    set_noise_variance(problem.noise_variance, covariance[gain, gain], samples, trend, scratch)
    predict_covariance(covariance, scratch.noise_variance, scratch)
    for j in range(logs.shape[0]):
        covariance[first + j, first + j] += problem.parameter_noise[tick, j]


@njit
def update_plain(jaw: Jaw, mean, covariance, measured, variances, scratch: JointScratch):
    """Measurement update; NaN in ``measured`` (12) was not read."""
    size = mean.shape[0]
    measure(jaw, mean, scratch.rows, scratch.expected)
    for j in range(size):
        scratch.shift[j] = 0.0
    for i in range(N_MEASUREMENTS):
        if measured[i] != measured[i]:
            continue
        row = scratch.rows[i]
        variance = innovation_variance(covariance, row, variances[i], scratch.gain)
        innovation = measured[i] - scratch.expected[i]
        for k in range(row.shape[0]):
            innovation -= row[k] * scratch.shift[k]
        reduce_covariance(covariance, scratch.gain, variance)
        for j in range(size):
            scratch.shift[j] += innovation / variance * scratch.gain[j]
    for j in range(size - 1):
        mean[j] += scratch.shift[j]


@njit
def filter_record(problem: Problem, means, covariance, ticks, covariances, scratch: JointScratch):
    """Filter a record of T ticks.

    Args:
        problem: See ``Problem``.
        means: (T + 1, n + p + 1); row 0 holds the mean before the first reading, and all rows are filled with the means
            after the readings of that time.
        covariance: (n + p + 1, n + p + 1) before the first reading; changed.
        ticks: (K,) increasing numbers of the times whose covariance is wanted.
        covariances: (K, p, p) of the parameters at those times; overwritten.
        scratch: Working memory.
    """
    parameters = problem.floor.shape[0]
    first = means.shape[1] - 1 - parameters
    trend = np.zeros(N_WRENCH)
    row = 0
    for k in range(means.shape[0]):
        if k > 0:
            means[k] = means[k - 1]
            predict_plain(problem, k - 1, means[k], covariance, trend, scratch)
            follow_trend(trend, problem.samples[k - 1], problem.dt)
        update_plain(problem.jaw, means[k], covariance, problem.measured[k], problem.variances, scratch)
        if row < ticks.shape[0] and ticks[row] == k:
            for i in range(parameters):
                for j in range(parameters):
                    covariances[row, i, j] = covariance[first + i, first + j]
            row += 1
