"""The posterior Cramer-Rao bound along a record's motion: how well its parameters could be known, and when.

Tichavsky, Muravchik & Nehorai (1998, IEEE Trans. Signal Process. 46:1386) give the bound of the joint problem of motion
and parameters as a recursion. For Gaussian noise it is the filter's covariance recursion, linearised at the true motion
instead of the estimated one, without process noise on the parameters. It is the same recursion as the environment's
(``track_bound``). The load cell's gain error is considered here too (Schmidt 1966), so that with ``gain_sd`` above 0 it
bounds estimators that do not learn the gain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.analysis.path import MotionPath, path_of
from jawenv.base.errors import InputError
from jawenv.filter.bound.joint_recursion import JointScratch, predict_covariance, take_rows
from jawenv.filter.bound.joint_step import propagate
from jawenv.filter.model.encoders import measure
from jawenv.filter.readings.cell_trend import follow_trend
from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Bound:
    """Smallest covariance of p natural-log parameters that an unbiased estimator could have, at K times."""

    time: Array  # (K,) s
    cov: Array  # (K, p, p)
    prior_sd: Array  # (p,) before the first measurement

    @property
    def sd(self) -> Array:
        """(K, p) standard deviations, so 0.05 is 5 %."""
        return np.sqrt(np.diagonal(self.cov, axis1=-2, axis2=-1))

    @property
    def information(self) -> Array:
        """(K,) nats since the prior: half the fall of the log-determinant."""
        _, log_det = np.linalg.slogdet(self.cov)
        return np.asarray(np.log(self.prior_sd).sum() - 0.5 * log_det, dtype=np.float64)


@njit
def _update_covariance(jaw: Jaw, state, covariance, variances, used, scratch: JointScratch):
    """Measurement update of the covariance alone, linearised at ``state``: the recursion of the bound.

    All readings at once: with S = H P H^T + R = L L^T and W = L^-1 H P, P <- P - W^T W. NaN where S has no factor.
    """
    measure(jaw, state, scratch.rows, scratch.expected)
    take_rows(covariance, variances, used, scratch)


@njit
def _bound_path(path: MotionPath, covariance, every, covariances):
    """Run the recursion over all ticks of a ``MotionPath``; ``covariance`` is the prior's, and is changed.

    The parameters' block after ticks 0, ``every``, 2 ``every``, ... goes into ``covariances`` (K, p, p), and that
    after the last tick into its last row.
    """
    jaw, scratch, states = path.jaw, path.scratch, path.states
    n_states, size, ticks = states.shape[1], covariances.shape[1], path.wrenches.shape[0]
    trend = np.zeros(N_WRENCH)
    state = np.empty(n_states)
    for tick in range(ticks + 1):
        if tick > 0:
            state[:] = states[tick - 1]
            propagate(jaw, path.muscles, state, path.wrenches[tick - 1], trend, 0.0, path.dt, scratch)
            predict_covariance(covariance, path.noise_variance, scratch)
            follow_trend(trend, path.samples[tick - 1], path.dt)
        _update_covariance(jaw, states[tick], covariance, path.measurement_variance, path.used[tick], scratch)
        if tick % every == 0 or tick == ticks:
            row = covariances.shape[0] - 1 if tick == ticks else tick // every
            for i in range(size):
                for j in range(size):
                    covariances[row, i, j] = covariance[n_states + i, n_states + j]


def bound_along(record: Record, parameters: Array | None = None, every: int = 1) -> Bound:
    """The bound along a record's motion.

    Args:
        record: with ``states``: the true ones of a simulation, or an estimate put in by
            ``dataclasses.replace``. Without ``wrenches`` the load cell's samples stand for them.
        parameters: (p,) natural-log parameters at which the model is linearised; None for the record's ``truth``.
        every: ticks from one kept time to the next; the last tick is always kept.

    Returns:
        The bound from the first measurement (time 0) to the last.

    Raises:
        InputError: the record has no states, there are no parameters, ``every`` is not a whole number of 1 or more, or
            the recursion has no result, as with states that are not finite.
    """
    if isinstance(every, bool) or not isinstance(every, int | np.integer) or every < 1:
        raise InputError(f"every is {every!r}; allowed: a whole number of ticks, 1 or more")
    bound = _path_bound(path_of(record, parameters), record, int(every))
    if not np.isfinite(bound.cov).all():
        raise InputError("record: states, wrenches or samples are not finite, or no jaw's: the bound has no value")
    return bound


def _path_bound(path: MotionPath, record: Record, every: int) -> Bound:
    """The bound along a ``MotionPath``, kept every ``every`` ticks and at the last."""
    ticks, parameters = len(path.wrenches), len(record.parameter_names)
    rows = np.unique(np.append(np.arange(0, ticks + 1, every), ticks))
    covariances = np.empty((len(rows), parameters, parameters))
    _bound_path(path, path.covariance.copy(), every, covariances)
    return Bound(time=record.time[rows], cov=covariances, prior_sd=np.array(record.prior.sd))
