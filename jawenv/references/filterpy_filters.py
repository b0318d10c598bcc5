"""filterpy's extended and unscented Kalman filters on the same model: independent implementations as references.

The extended filter has the model of ``numpy_model`` where the jaw is a midline one. It then shares nothing compiled
with ``ExtendedKalman``; equal results verify model, derivative and filter. The unscented filter has no compiled
counterpart and moves its sigma points by the kernels.

Both have the state of ``joint_recursion``: motion, natural-log parameters, gain error of the load cell. The noise of
the motion is G W G^T, with the wrench's variance W and its effect G taken at the mean. The gain error is a considered
parameter (Schmidt 1966): after the optimal update its mean and variance are restored. Its cross-covariance and all
other means and covariances are the same in both filters.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.base.extras import needs
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record
from jawenv.references.filterpy_models import CompiledModel, MotionModel, NumpyModel
from jawenv.references.initial import check_every, check_noise, initial_belief, output_ticks

with needs("a reference filter", "filterpy", "reference"):
    from filterpy.kalman import ExtendedKalmanFilter, MerweScaledSigmaPoints, UnscentedKalmanFilter

Array = NDArray[np.float64]

# Of the scaled unscented transform. With 23 states and alpha 1 a point lies 4.8 sds out, where a b of sd 0.5 is eleven
# times too large; 0.1 puts it at half an sd. beta 2 is for normal distributions (Wan & van der Merwe 2000).
ALPHA, BETA, KAPPA = 0.1, 2.0, 0.0


class _Extended(ExtendedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter with a model's motion."""

    def __init__(self, model: MotionModel) -> None:
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

    def __init__(self, model: MotionModel, alpha: float) -> None:
        points = MerweScaledSigmaPoints(model.size, alpha, BETA, KAPPA, sqrt_method=_symmetric_root)
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


def _symmetric_root(P: Array) -> Array:
    """U with U^T U = P, by the eigenvectors of the correlations; what is negative of them by rounding counts as zero.

    A Cholesky factor does not exist where a coordinate is held or the gain error known, and fails where rounding makes
    a correlation reach one.
    """
    sd = np.sqrt(np.diag(P))
    scale = np.where(sd > 0.0, sd, 1.0)
    values, vectors = np.linalg.eigh(P / np.outer(scale, scale))
    root: Array = (vectors * np.sqrt(np.maximum(values, 0.0))).T * sd
    return root


def _run(name: str, kalman: Any, model: MotionModel, every: int) -> Estimate:
    """Filter a record, the gain error considered; what follows a divergence is NaN."""
    record, parameters = model.record, slice(model.n, model.size - 1)
    ticks = output_ticks(record, every)
    count = len(record.prior.mean)
    means, covs = np.full((len(ticks), count), np.nan), np.full((len(ticks), count, count), np.nan)
    row = 0
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
        if ticks[row] == k:
            means[row], covs[row] = kalman.x[parameters], kalman.P[parameters, parameters]
            row += 1
    return Estimate(name, record.time[ticks], means, covs)


class FilterpyExtendedKalman:
    """filterpy's ``ExtendedKalmanFilter``: the same numbers as ``ExtendedKalman``, much slower.

    Motion, readings and their derivatives are those of ``numpy_model``.

    Args:
        parameter_rate: as in ``ExtendedKalman``.
        parameter_time: likewise, s.
        every: ticks between the kept estimates; the last is always kept.
        compiled_model: whether to take the compiled model for any jaw: the same numbers to rounding, some forty times
            as fast, and a check of the filter's algebra alone.
    """

    name = "extended Kalman, filterpy"

    def __init__(
        self,
        parameter_rate: float = 0.03,
        parameter_time: float = 5.0,
        every: int = 5,
        *,
        compiled_model: bool = False,
    ) -> None:
        check_noise("FilterpyExtendedKalman", parameter_rate, parameter_time)
        check_every("FilterpyExtendedKalman", every)
        self.parameter_rate, self.parameter_time, self.every = parameter_rate, parameter_time, every
        self.compiled_model = compiled_model

    def estimate(self, record: Record) -> Estimate:
        """The belief at every ``every``-th tick."""
        kind: type[MotionModel] = CompiledModel if self.compiled_model else NumpyModel
        model = kind(record, self.parameter_rate, self.parameter_time)
        return _run(self.name, _Extended(model), model, self.every)


class FilterpyUnscentedKalman:
    """filterpy's ``UnscentedKalmanFilter`` with the scaled sigma points of van der Merwe.

    Args:
        parameter_rate: as in ``ExtendedKalman``.
        parameter_time: likewise, s.
        every: ticks between the kept estimates; the last is always kept.
        alpha: spread of the sigma points, in (0, 1].
    """

    name = "unscented Kalman, filterpy"

    def __init__(
        self, parameter_rate: float = 0.03, parameter_time: float = 5.0, every: int = 5, alpha: float = ALPHA
    ) -> None:
        check_noise("FilterpyUnscentedKalman", parameter_rate, parameter_time)
        check_every("FilterpyUnscentedKalman", every)
        if not 0.0 < alpha <= 1.0:
            raise InputError(f"FilterpyUnscentedKalman: alpha is {alpha!r}; allowed: numbers in (0, 1]")
        self.parameter_rate, self.parameter_time, self.every = parameter_rate, parameter_time, every
        self.alpha = alpha

    def estimate(self, record: Record) -> Estimate:
        """The belief at every ``every``-th tick."""
        model = CompiledModel(record, self.parameter_rate, self.parameter_time)
        return _run(self.name, _Unscented(model, self.alpha), model, self.every)
