"""Initial belief, process noise and working memory of the estimators of records."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.bound.joint_recursion import joint_scratch_dtype
from jawenv.kernels.records import record_zeros
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


def initial_belief(record: Record) -> tuple[Array, Array]:
    """Mean and covariance of motion, p natural-log parameters and load-cell gain error before the first reading.

    Returns:
        (n + p + 1,) and (n + p + 1, n + p + 1).
    """
    record.require_exact("reference filter")
    mean = np.concatenate([record.start_mean, record.prior.mean, [0.0]])
    sd = np.concatenate([record.start_sd, record.prior.sd, [record.gain_sd]])
    return mean, np.diag(sd**2)


def working_memory(record: Record) -> Any:
    """Scratch of the filter's kernels for the sizes of this record."""
    muscles, lines = len(record.parameter_names) // 2, len(record.jaw["l_o"])
    return record_zeros(1, joint_scratch_dtype(muscles, lines, len(record.start_mean)))[0]


def parameter_noise(record: Record, rate: float, time_constant: float) -> Array:
    """(T,) process-noise variance of each log-parameter in each tick: the integral of a decaying variance rate.

    Args:
        record: gives the ticks.
        rate: sd per square root of a second at the start.
        time_constant: of the sd's decay, s; infinite for a constant noise.
    """
    if np.isinf(time_constant):
        return np.full(len(record.samples), rate**2 * record.dt)
    half_life = 0.5 * time_constant
    decay = np.exp(-np.arange(len(record.samples)) * record.dt / half_life)
    noise: Array = rate**2 * half_life * -np.expm1(-record.dt / half_life) * decay
    return noise


def output_ticks(record: Record, every: int) -> NDArray[np.int64]:
    """Numbers of the times of a record of which an estimate is kept: each ``every``-th, and the last."""
    last = len(record.time) - 1
    return np.unique(np.append(np.arange(0, last, every), last))
