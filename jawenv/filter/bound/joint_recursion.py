"""The joint Kalman recursion over motion, log-parameters and load-cell gain: what the bound and the reference share.

State: q and u (10), natural logs of F_o and b per muscle (12 by default), relative
gain error g of the load cell (1); 23 in all by default. The sizes come with the arrays.

* The force on the jaw is the reading plus g times the recent trend of the readings. If g multiplied the reading itself,
  the load cell's noise would be correlated with the regressor of g and bias it.
* g is a considered parameter (Schmidt 1966): its prior variance enters all cross-covariances and is never reduced.
* g times the departure of the readings from their trend is modelled as additional process noise.
* Process noise is an unmodelled wrench, constant over one step, plus the noise of the load cell, which also has a
  linear part.

The covariance recursion is separate from the mean's, so that along the true trajectory it is the posterior Cramer-Rao
bound (Tichavsky, Muravchik & Nehorai 1998). The bound takes all measurements of a tick at once. The reference filters
take them one by one, which equals that to rounding: their noise is independent, and all are linearised at the predicted
mean. The environments' own filter does not carry the parameters in its state (``filter.belief.state``).
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.filter.belief.state import joint_size
from jawenv.filter.bound.joint_step import Sensitivity, copy_matrix
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_NOISE, predict_cov
from jawenv.filter.readings.cell_trend import mean_reading
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import decompose, multiply, subtract_product, whiten
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH, linear_dtype


class Recursion:
    """Working memory of the covariance's recursion."""

    total: Annotated[Array, "moving", "columns"]  # [F, G]
    covariance: Annotated[Array, "size", "size"]
    moved_cov: Annotated[Array, "moving", "size"]  # F P
    weighted: Annotated[Array, "moving", "columns"]  # [F P, G W]
    turned: Annotated[Array, "columns", "moving"]
    next_cov: Annotated[Array, "moving", "moving"]
    rows: Annotated[Array, N_MEASUREMENTS, "read"]  # H
    turned_rows: Annotated[Array, "read", N_MEASUREMENTS]  # H^T
    read_cov: Annotated[Array, "read", "size"]
    factor: Annotated[Array, N_MEASUREMENTS, N_MEASUREMENTS]  # L of the innovations' covariance
    whitened: Annotated[Array, N_MEASUREMENTS, "size"]  # L^-1 H P
    gains: Annotated[Array, "size", N_MEASUREMENTS]  # its transpose


@cache
def recursion_dtype(n_moving: int, n_read: int, size: int) -> np.dtype[np.void]:
    """Dtype of ``Recursion``.

    Args:
        n_moving: states that a tick moves, the first ones.
        n_read: states that readings depend on, these and the next ones.
        size: all states.
    """
    n_columns = size + N_NOISE
    return record_dtype(Recursion, moving=n_moving, columns=n_columns, size=size, read=n_read)


class JointScratch(Recursion, Sensitivity):
    """The filter's working memory."""

    muscles: Annotated[Array, "lines", 2]
    state: Annotated[Array, "states"]
    row: Annotated[Array, "states"]
    expected: Annotated[Array, N_MEASUREMENTS]
    noise_variance: Annotated[Array, N_NOISE]
    shift: Annotated[Array, "size"]
    gain: Annotated[Array, "size"]


@cache
def joint_scratch_dtype(n_muscles: int = 6, n_lines: int = 6, n_states: int = N_STATES) -> np.dtype[np.void]:
    """Dtype of ``JointScratch``."""
    n_filter = joint_size(n_muscles, n_states)
    return record_dtype(
        JointScratch,
        linear=linear_dtype(n_lines, n_states, n_muscles),
        states=n_states,
        moving=n_states,
        read=n_states,
        columns=n_filter + N_NOISE,
        size=n_filter,
        lines=n_lines,
    )


@njit
def predict_covariance(covariance, noise_variance, scratch: Recursion):
    """P <- F P F^T + G W G^T, with F and G from ``scratch.total`` as left by ``propagate``.

    ``noise_variance`` (12) is W's diagonal; ``covariance`` need be no field of a record.
    """
    copy_matrix(scratch.covariance, covariance)
    predict_cov(scratch.covariance, noise_variance, scratch)
    copy_matrix(covariance, scratch.covariance)


@njit
def set_noise_variance(wrench_variance, gain_variance, samples, trend, scratch: JointScratch):
    """Process noise: ``wrench_variance`` (12), and the gain error times what departs from the trend."""
    for k in range(N_WRENCH):
        fast = mean_reading(samples, k) - trend[k]
        scratch.noise_variance[k] = wrench_variance[k] + gain_variance * fast * fast
        scratch.noise_variance[N_WRENCH + k] = wrench_variance[N_WRENCH + k]


@njit
def innovation_variance(covariance, row, variance, gain):
    """Variance of the innovation of one scalar measurement; leaves P h in ``gain``."""
    size = gain.shape[0]
    for j in range(size):
        gain[j] = 0.0
    for k in range(row.shape[0]):
        factor = row[k]
        if factor != 0.0:
            for j in range(size):
                gain[j] += factor * covariance[k, j]
    for k in range(row.shape[0]):
        variance += row[k] * gain[k]
    return variance


@njit
def take_rows(covariance, variances, used, scratch: Recursion):
    """Measurement update of the covariance alone, by the derivative of the readings in ``scratch.rows``."""
    rows, factor, whitened, gains = scratch.rows, scratch.factor, scratch.whitened, scratch.gains
    size, n_read = covariance.shape[0], rows.shape[1]
    for i in range(N_MEASUREMENTS):
        if not used[i]:
            rows[i, :] = 0.0
    copy_matrix(scratch.covariance, covariance)
    for i in range(n_read):
        for j in range(size):
            scratch.read_cov[i, j] = covariance[i, j]
    multiply(rows, scratch.read_cov, whitened)
    for i in range(N_MEASUREMENTS):
        for k in range(n_read):
            scratch.turned_rows[k, i] = rows[i, k]
    multiply(whitened, scratch.turned_rows, factor)
    for i in range(N_MEASUREMENTS):
        factor[i, i] += variances[i] if used[i] else 1.0
    if not decompose(factor):
        covariance[:, :] = np.nan
        return
    whiten(factor, whitened)
    for i in range(size):
        for k in range(N_MEASUREMENTS):
            gains[i, k] = whitened[k, i]
    subtract_product(gains, whitened, scratch.covariance)
    considered = covariance[size - 1, size - 1]
    copy_matrix(covariance, scratch.covariance)
    covariance[size - 1, size - 1] = considered
