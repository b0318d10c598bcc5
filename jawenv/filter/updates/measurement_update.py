"""Measurement update with the encoders at the end of a tick, and the gate before it.

All twelve readings are taken at once, linearised at the predicted motion. With the innovations' covariance S = H P H^T
+ R = L L^T, everything is a product with the whitened rows W = L^-1 H: the Kalman gain is P W^T L^-1, and the
information about the tensions grows by W_c^T W_c and the score by W_c^T L^-1 nu, where W_c = W ``by_tension``. A
reading that is not used has a row of zeros, no innovation and the variance 1.

The gate. The normalised innovation squared (NIS) follows chi-squared if the parameters are at their mean (Bar-Shalom,
Li & Kirubarajan 2001, section 5.4). Above the gate it is tested again with the innovation covariance
S + C Cov(c) C^T, C = H ``by_tension``, which includes the parameters' uncertainty. One that passes only this test says
that the parameters are far from their mean, and the belief has to be renewed at once (``tick``). One that fails it too
adds no information; the motion's covariance is scaled up until the NIS is as expected, so that the motion follows the
readings. While the belief is wide (``WIDE``) the next one after ``PATIENCE`` such ticks on end counts as explained by
the parameters. Their uncertainty is linearised here, and an exponential law with uncertain b can be many
of its sds away. So it is where muscles alone are unknown and the jaw is on one point.
"""

from __future__ import annotations

from functools import cache
from math import inf, isfinite, sqrt
from typing import Annotated

import numpy as np

from jawenv.filter.belief.state import Belief, FilterSettings, lose_motion, shared_columns, tension_columns
from jawenv.filter.model.basis import set_derivatives
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.nuisances.if_any import NuisanceScratch, add_nuisance_readings, nuisance_scratch_dtype
from jawenv.filter.updates.instrument import set_rows_of_past
from jawenv.kernels.cholesky import solve_lower
from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.linalg import add_squares, decompose, multiply, subtract_product, whiten
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.jaw import Jaw

WIDE = 0.5  # sd of a natural logarithm
PATIENCE = 5  # ticks on end whose readings are refused: an outlier does not last, a false belief does
GATE = 100.0  # chi-squared of 12 has a chance of 1e-15 to be above
# What explains an innovation: motion and noise, the parameters' uncertainty as well, or nothing.
EXPECTED, SURPRISING, REFUSED = 0, 1, 2


class UpdateScratch:
    """Working memory of the measurement update."""

    nuisances: NuisanceScratch
    whitened_nuisances: Annotated[Array, "shared", N_MEASUREMENTS]
    rows: Annotated[Array, N_MEASUREMENTS, "motion"]  # H
    expected: Annotated[Array, N_MEASUREMENTS]
    innovation: Annotated[Array, N_MEASUREMENTS]
    variance: Annotated[Array, N_MEASUREMENTS]  # R
    factor: Annotated[Array, N_MEASUREMENTS, N_MEASUREMENTS]  # L
    whitened_innovation: Annotated[Array, N_MEASUREMENTS]
    whitened_motion: Annotated[Array, N_MEASUREMENTS, "motion"]  # L^-1 H P
    by_tension_rows: Annotated[Array, N_MEASUREMENTS, "columns"]  # H by_tension, then whitened
    gain: Annotated[Array, "motion", N_MEASUREMENTS]  # transpose of ``whitened_motion``
    by_log: Annotated[Array, "columns", "parameters"]  # derivative of the coefficients by the parameters
    by_log_rows: Annotated[Array, N_MEASUREMENTS, "parameters"]
    spread: Annotated[Array, N_MEASUREMENTS, "parameters"]


@cache
def update_scratch_dtype(n_muscles: int, n_lines: int, n_motion: int, n_nuisances: int = 0) -> np.dtype[np.void]:
    """Dtype of ``UpdateScratch``."""
    columns, parameters = tension_columns(n_muscles, n_nuisances), 2 * n_muscles
    return record_dtype(
        UpdateScratch,
        nuisances=nuisance_scratch_dtype(n_lines, n_nuisances),
        shared=shared_columns(n_nuisances),
        motion=n_motion,
        columns=columns,
        parameters=parameters,
    )


@njit
def _set_innovation(jaw: Jaw, motion, measured, variances, used, scratch: UpdateScratch):
    """Innovations, rows and variances of the readings in use."""
    measure(jaw, motion, scratch.rows, scratch.expected)
    for i in range(N_MEASUREMENTS):
        if used[i]:
            scratch.innovation[i] = measured[i] - scratch.expected[i]
            scratch.variance[i] = variances[i]
        else:
            scratch.innovation[i], scratch.variance[i] = 0.0, 1.0
            scratch.rows[i, :] = 0.0


@njit
def _set_factor(covariance, scratch: UpdateScratch):
    """S = H P H^T + R into the lower half of ``factor``; H P into ``whitened_motion``, not whitened yet."""
    rows, factor, moved = scratch.rows, scratch.factor, scratch.whitened_motion
    multiply(rows, covariance, moved)
    for i in range(N_MEASUREMENTS):
        for j in range(i + 1):
            value = scratch.variance[i] if i == j else 0.0
            for k in range(rows.shape[1]):
                value += moved[i, k] * rows[j, k]
            factor[i, j] = value


@njit
def squared_length(scratch: UpdateScratch):
    """Innovation whitened by ``factor``, its squared length: NIS, the normalised innovation squared."""
    whitened, total = scratch.whitened_innovation, 0.0
    whitened[:] = scratch.innovation
    solve_lower(scratch.factor, whitened)
    for i in range(N_MEASUREMENTS):
        total += whitened[i] * whitened[i]
    return total


@njit
def normalised_innovation(belief: Belief, scratch: UpdateScratch):
    """NIS given the parameters' mean; leaves ``factor``. Infinite if S is not positive definite."""
    _set_factor(belief.motion_cov, scratch)
    if not decompose(scratch.factor):
        return inf
    value = squared_length(scratch)
    return value if isfinite(value) else inf


@njit
def add_muscles(belief: Belief, scratch: UpdateScratch):
    """Add to S, in the lower half of ``factor``, the innovation covariance due to the parameters' uncertainty."""
    set_derivatives(belief.basis, belief.mean, scratch.by_log)
    multiply(scratch.by_tension_rows, scratch.by_log, scratch.by_log_rows)
    multiply(scratch.by_log_rows, belief.cov, scratch.spread)
    for i in range(N_MEASUREMENTS):
        for j in range(i + 1):
            for k in range(scratch.spread.shape[1]):
                scratch.factor[i, j] += scratch.spread[i, k] * scratch.by_log_rows[j, k]
    _add_nuisances(belief, scratch)


@njit
def _add_nuisances(belief: Belief, scratch: UpdateScratch):
    """Add the same due to gain error and nuisances at given tensions."""
    first = belief.nominal.shape[0] * belief.nominal.shape[1]
    rows, turned = scratch.by_tension_rows, scratch.whitened_nuisances
    for k in range(turned.shape[0]):
        for i in range(N_MEASUREMENTS):
            turned[k, i] = rows[i, first + k]
    whiten(belief.nuisance_factor, turned)
    for i in range(N_MEASUREMENTS):
        for j in range(i + 1):
            for k in range(turned.shape[0]):
                scratch.factor[i, j] += turned[k, i] * turned[k, j]


@njit
def judge_innovation(belief: Belief, start_sd, scratch: UpdateScratch):
    """The innovation's explanation, ``EXPECTED`` and so on; widens the motion if there is none. Leaves ``factor``."""
    nis = normalised_innovation(belief, scratch)
    if nis <= GATE:
        return EXPECTED
    explained = False
    if nis < inf:
        _set_factor(belief.motion_cov, scratch)
        add_muscles(belief, scratch)
        explained = decompose(scratch.factor) and (squared_length(scratch) <= GATE or belief.refused >= PATIENCE)
        if not explained:
            belief.motion_cov *= nis / N_MEASUREMENTS
    if not normalised_innovation(belief, scratch) < inf:
        lose_motion(belief, start_sd)
        scratch.by_tension_rows[:, :] = 0.0
        normalised_innovation(belief, scratch)
        return REFUSED
    return SURPRISING if explained else REFUSED


@njit
def _is_wide(belief: Belief):
    """Whether a parameter is so uncertain that an exponential law is far from what its derivative says."""
    largest = 0.0
    for i in range(belief.cov.shape[0]):
        largest = max(largest, belief.cov[i, i])
    return largest > WIDE * WIDE


@njit_within
def update_motion(jaw: Jaw, belief: Belief, measured, used, weight, settings: FilterSettings, scratch: UpdateScratch):
    """Update ``belief`` with the ``used`` ones of the readings ``measured`` (12); returns what explains them.

    Args:
        jaw: The filter's model.
        belief: State of the filter, predicted to the time of the readings.
        measured: (12,).
        used: (12,).
        weight: What they count for as information; 0 where nothing can be learnt from them.
        settings: Variances of the encoders, sds that the motion is reset to where S is not positive definite, and the
            nuisances (``FilterSettings``).
        scratch: Working memory.
    """
    _set_innovation(jaw, belief.motion, measured, settings.measurement_variance, used, scratch)
    set_rows_of_past(jaw, belief, used, scratch)
    if settings.motion_only:
        verdict = judge_innovation(belief, settings.start_sd, scratch)
        _correct_state(belief, scratch)
        return verdict
    multiply(scratch.rows, belief.by_tension, scratch.by_tension_rows)
    add_nuisance_readings(jaw, belief, settings, used, scratch)
    verdict = judge_innovation(belief, settings.start_sd, scratch)
    alone = belief.nuisances.shape[0] == 0  # else slack straps are believed
    belief.refused = belief.refused + 1 if alone and verdict == REFUSED and _is_wide(belief) else 0
    correct_motion(belief, scratch)
    if weight > 0.0 and verdict != REFUSED:
        add_information(belief, weight, scratch)
    return verdict


@njit
def correct_motion(belief: Belief, scratch: UpdateScratch):
    """Kalman update of motion, covariance and derivative by the tensions, given ``factor``."""
    _correct_state(belief, scratch)
    whiten(scratch.factor, scratch.by_tension_rows)
    subtract_product(scratch.gain, scratch.by_tension_rows, belief.by_tension)


@njit
def _correct_state(belief: Belief, scratch: UpdateScratch):
    """Kalman update of motion and covariance, given ``factor``; leaves ``gain``."""
    whitened, innovation, gain = scratch.whitened_motion, scratch.whitened_innovation, scratch.gain
    whiten(scratch.factor, whitened)
    for i in range(gain.shape[0]):
        for k in range(N_MEASUREMENTS):
            gain[i, k] = whitened[k, i]
            belief.motion[i] += whitened[k, i] * innovation[k]
    subtract_product(gain, whitened, belief.motion_cov)


@njit
def add_information(belief: Belief, weight, scratch: UpdateScratch):
    """Add the innovations' information and score about the tensions, which count by ``weight``."""
    rows, score, innovation = scratch.by_tension_rows, belief.score, scratch.whitened_innovation
    for i in range(N_MEASUREMENTS):
        for j in range(rows.shape[1]):
            score[j] += weight * rows[i, j] * innovation[i]
    root = sqrt(weight)
    rows *= root
    add_squares(rows, belief.information)
    rows /= root
