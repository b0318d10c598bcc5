"""filterpy's extended and unscented Kalman filters on the same model: references that others have written and tested.

Both have the state of ``ekf``: motion, natural-log parameters, gain error of the load cell. The noise of the motion is
G W G^T, with the wrench's variance W and its effect G taken at the mean. Considering the gain error (Schmidt 1966)
takes no other filter: after the optimal update, the mean and variance of what is considered are put back. Its
covariance with everything else, and everything else's mean and covariance, are the same in both.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter
from numpy.typing import NDArray

from jawenv.errors import InputError
from jawenv.estimation.ekf import move, set_muscles, set_wrench_variance
from jawenv.estimation.estimator import Estimate
from jawenv.estimation.initial import (
    check_every,
    check_noise,
    initial_belief,
    kept_ticks,
    parameter_noise,
    trends,
    working_memory,
)
from jawenv.estimation.measurement import N_MEASUREMENTS, expect
from jawenv.estimation.record import Record
from jawenv.mechanics.dynamics import N_WRENCH

Array = NDArray[np.float64]

# Of the scaled unscented transform. With 23 states and alpha 1 a point lies 4.8 sds out, where a b of sd 0.5 is eleven
# times too large; 0.1 puts it at half an sd. beta 2 is for normal distributions (Wan & van der Merwe 2000).
ALPHA, BETA, KAPPA = 0.1, 2.0, 0.0


class _Model:
    """The model of one record as filterpy asks for it: functions of a state vector."""

    def __init__(self, record: Record, parameter_rate: float, parameter_time: float) -> None:
        self.record = record
        self.n, self.size = len(record.start_mean), len(record.start_mean) + len(record.prior.mean) + 1
        self.noise = parameter_noise(record, parameter_rate, parameter_time)
        self.trends = trends(record)
        self.variances = record.measurement_sd**2
        self.scratch = working_memory(record)
        self.tick = 0

    def moved(self, x: Array) -> Array:
        """The state a tick later; its derivative is left in the scratch."""
        record, moved = self.record, x.copy()
        set_muscles(record.jaw, x, self.n, self.scratch["muscles"])
        samples, trend = record.samples[self.tick], self.trends[self.tick]
        move(record.jaw, self.scratch["muscles"], moved[: self.n], samples, trend, x[-1], record.dt, self.scratch)
        return moved

    def transition(self) -> Array:
        """F (s, s), of what was moved last."""
        F = np.eye(self.size)
        F[: self.n] = self.scratch["total"][:, :-N_WRENCH]
        return F

    def process_noise(self, gain_variance: float) -> Array:
        """Q (s, s), of what was moved last."""
        record = self.record
        set_wrench_variance(
            record.wrench_sd**2, gain_variance, record.samples[self.tick], self.trends[self.tick], self.scratch
        )
        G = self.scratch["total"][:, -N_WRENCH:]
        Q = np.diag(np.concatenate([np.zeros(self.n), np.full(len(record.prior.mean), self.noise[self.tick]), [0.0]]))
        Q[: self.n, : self.n] = (G * self.scratch["wrench_variance"]) @ G.T
        return Q

    def read(self, k: int) -> NDArray[np.bool_]:
        """(12,) which readings there are at time k."""
        read: NDArray[np.bool_] = np.isfinite(self.record.measured[k])
        return read

    def expected(self, x: Array, read: NDArray[np.bool_]) -> Array:
        """The readings to expect of x."""
        expect(self.record.jaw, x, self.scratch["rows"], self.scratch["expected"])
        return self.scratch["expected"][read].copy()  # type: ignore[no-any-return]

    def rows(self, x: Array, read: NDArray[np.bool_]) -> Array:
        """Their derivative by x."""
        expect(self.record.jaw, x, self.scratch["rows"], self.scratch["expected"])
        H = np.zeros((N_MEASUREMENTS, self.size))
        H[:, : self.n] = self.scratch["rows"]
        return H[read]


class _Extended(ExtendedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter with a model's motion."""

    def __init__(self, model: _Model) -> None:
        super().__init__(dim_x=model.size, dim_z=N_MEASUREMENTS)
        self.model = model
        self.x, self.P = initial_belief(model.record)

    def predict_x(self, u: Any = 0) -> None:
        """Move the mean; filterpy takes F and Q afterwards."""
        self.x = self.model.moved(self.x)
        self.F, self.Q = self.model.transition(), self.model.process_noise(self.P[-1, -1])

    def take(self, k: int) -> None:
        """Update with the readings at time k."""
        read = self.model.read(k)
        R = np.diag(self.model.variances[read])
        self.update(
            self.model.record.measured[k, read], self.model.rows, self.model.expected, R, args=(read,), hx_args=(read,)
        )


class _Unscented(UnscentedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter with a model's motion."""

    def __init__(self, model: _Model, alpha: float) -> None:
        points = MerweScaledSigmaPoints(model.size, alpha, BETA, KAPPA, sqrt_method=symmetric_root)
        super().__init__(
            model.size, N_MEASUREMENTS, model.record.dt, model.expected, lambda x, _: model.moved(x), points
        )
        self.model = model
        self.x, self.P = initial_belief(model.record)
        self.sigmas_f = points.sigma_points(self.x, self.P)

    def predict(self, **_: Any) -> None:
        """Predict with the process noise at the mean."""
        self.model.moved(self.x)
        self.Q = self.model.process_noise(self.P[-1, -1])
        super().predict()

    def take(self, k: int) -> None:
        """Update with the readings at time k."""
        read = self.model.read(k)
        R = np.diag(self.model.variances[read])
        self.update(self.model.record.measured[k, read], R, read=read)
        self.P = 0.5 * (self.P + self.P.T)


def symmetric_root(P: Array) -> Array:
    """U with U^T U = P, by the eigenvectors of the correlations; what is negative of them by rounding counts as zero.

    A Cholesky factor does not exist where a coordinate is held or the gain error known, and fails where rounding makes
    a correlation reach one.
    """
    sd = np.sqrt(np.diag(P))
    scale = np.where(sd > 0.0, sd, 1.0)
    values, vectors = np.linalg.eigh(P / np.outer(scale, scale))
    root: Array = (vectors * np.sqrt(np.maximum(values, 0.0))).T * sd
    return root


def _run(name: str, kalman: Any, model: _Model, every: int) -> Estimate:
    """Filter a record, the gain error considered; what follows a divergence is NaN."""
    record, parameters = model.record, slice(model.n, model.size - 1)
    kept = kept_ticks(record, every)
    count = len(record.prior.mean)
    means, covs = np.full((len(kept), count), np.nan), np.full((len(kept), count, count), np.nan)
    place = 0
    for k in range(len(record.time)):
        if k > 0:
            model.tick = k - 1
            kalman.predict()
        if model.read(k).any():
            considered = kalman.x[-1], kalman.P[-1, -1]
            kalman.take(k)
            kalman.x[-1], kalman.P[-1, -1] = considered
        if not (np.isfinite(kalman.x).all() and np.isfinite(kalman.P).all()):
            break
        if kept[place] == k:
            means[place], covs[place] = kalman.x[parameters], kalman.P[parameters, parameters]
            place += 1
    return Estimate(name, record.time[kept], means, covs)


class FilterpyExtendedKalman:
    """filterpy's ``ExtendedKalmanFilter``: the same numbers as ``ExtendedKalman``, much slower.

    Args:
        parameter_rate: as in ``ExtendedKalman``.
        parameter_time: likewise, s.
        every: ticks between the kept estimates; the last is always kept.

    Raises:
        InputError: an argument is out of range.
    """

    name = "extended Kalman, filterpy"

    def __init__(self, parameter_rate: float = 0.03, parameter_time: float = 5.0, every: int = 5) -> None:
        check_noise("FilterpyExtendedKalman", parameter_rate, parameter_time)
        check_every("FilterpyExtendedKalman", every)
        self.parameter_rate, self.parameter_time, self.every = parameter_rate, parameter_time, every

    def estimate(self, record: Record) -> Estimate:
        """The belief at every ``every``-th tick."""
        model = _Model(record, self.parameter_rate, self.parameter_time)
        return _run(self.name, _Extended(model), model, self.every)


class FilterpyUnscentedKalman:
    """filterpy's ``UnscentedKalmanFilter`` with the scaled sigma points of van der Merwe.

    Args:
        parameter_rate: as in ``ExtendedKalman``.
        parameter_time: likewise, s.
        every: ticks between the kept estimates; the last is always kept.
        alpha: spread of the sigma points, in (0, 1].

    Raises:
        InputError: an argument is out of range.
    """

    name = "unscented Kalman, filterpy"

    def __init__(
        self, parameter_rate: float = 0.03, parameter_time: float = 5.0, every: int = 5, alpha: float = ALPHA
    ) -> None:
        check_noise("FilterpyUnscentedKalman", parameter_rate, parameter_time)
        check_every("FilterpyUnscentedKalman", every)
        if not 0.0 < alpha <= 1.0:
            raise InputError(f"FilterpyUnscentedKalman: alpha is {alpha!r}, allowed are numbers in (0, 1]")
        self.parameter_rate, self.parameter_time, self.every = parameter_rate, parameter_time, every
        self.alpha = alpha

    def estimate(self, record: Record) -> Estimate:
        """The belief at every ``every``-th tick."""
        model = _Model(record, self.parameter_rate, self.parameter_time)
        return _run(self.name, _Unscented(model, self.alpha), model, self.every)
