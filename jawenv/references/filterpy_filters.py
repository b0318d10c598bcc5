"""filterpy's extended Kalman filter on the same model: an independent implementation as a reference.

It has the model of ``numpy_model`` where the jaw is a midline one. It then shares nothing compiled with
``ExtendedKalman``; equal results verify model, derivative and filter.

The state is that of ``joint_recursion``: motion, natural-log parameters, gain error of the load cell. The noise of the
motion is G W G^T, with the wrench's variance W and its effect G taken at the mean. The gain error is a considered
parameter (Schmidt 1966): after the optimal update its mean and variance are restored.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.extras import needs
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.model.joint_step import N_NOISE, propagate, set_muscles
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.newton_euler import measurement
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record
from jawenv.references import initial
from jawenv.references.numpy_model import measurement_with_derivative, step_with_derivative

with needs("a reference filter", "filterpy", "reference"):
    from filterpy.kalman import ExtendedKalmanFilter


Array = NDArray[np.float64]


class MotionModel(ABC):
    """The model of one record: s = n + p + 1 states, of motion, natural-log parameters, and the load cell's gain error.

    Args:
        record: T ticks.
        parameter_rate: noise of the parameters, as in ``ExtendedKalman``.
        parameter_time: likewise, s.
    """

    def __init__(self, record: Record, parameter_rate: float, parameter_time: float) -> None:
        self.record = record
        self.n, self.size = len(record.start_mean), len(record.start_mean) + len(record.prior.mean) + 1
        self.noise = initial.parameter_noise(record, parameter_rate, parameter_time)
        self.trends = initial.trends(record)
        self.fast = initial.mean_readings(record) - self.trends
        self.variances = record.measurement_sd**2
        self.tick = 0
        self.total = np.zeros((self.n, self.size + N_NOISE))  # derivative of the last motion

    @abstractmethod
    def moved(self, x: Array) -> Array:
        """The state (s,) a tick after x; its derivative by x and by the wrench not known is left in ``total``."""

    @abstractmethod
    def expected(self, x: Array, read: NDArray[np.bool_]) -> Array:
        """The readings to measure of x, where ``read`` (12,) is True."""

    @abstractmethod
    def rows_by_motion(self, x: Array) -> Array:
        """Derivative (12, n) of all readings by the motion."""

    def rows(self, x: Array, read: NDArray[np.bool_]) -> Array:
        """Derivative of ``expected`` by x."""
        H = np.zeros((N_MEASUREMENTS, self.size))
        H[:, : self.n] = self.rows_by_motion(x)
        return H[read]

    def transition(self) -> Array:
        """F (s, s) of the last motion."""
        F = np.eye(self.size)
        F[: self.n] = self.total[:, :-N_NOISE]
        return F

    def process_noise(self, gain_variance: float) -> Array:
        """Q (s, s) of the last motion."""
        record, G = self.record, self.total[:, -N_NOISE:]
        variance = record.noise_variance
        variance[:N_WRENCH] += gain_variance * self.fast[self.tick] ** 2
        Q = np.diag(np.concatenate([np.zeros(self.n), np.full(len(record.prior.mean), self.noise[self.tick]), [0.0]]))
        Q[: self.n, : self.n] = (G * variance) @ G.T
        return Q

    def read(self, k: int) -> NDArray[np.bool_]:
        """(12,) which readings there are at time k."""
        read: NDArray[np.bool_] = np.isfinite(self.record.measured[k])
        return read


class CompiledModel(MotionModel):
    """The kernels that ``ExtendedKalman`` runs, for any jaw."""

    def __init__(self, record: Record, parameter_rate: float, parameter_time: float) -> None:
        super().__init__(record, parameter_rate, parameter_time)
        self.scratch = initial.working_memory(record)
        self.total = self.scratch["total"]

    def moved(self, x: Array) -> Array:
        """The state (s,) a tick after x, by the compiled ``propagate``."""
        record, moved = self.record, x.copy()
        set_muscles(record.jaw, x, self.n, self.scratch["muscles"])
        samples, trend = record.samples[self.tick], self.trends[self.tick]
        propagate(record.jaw, self.scratch["muscles"], moved[: self.n], samples, trend, x[-1], record.dt, self.scratch)
        return moved

    def expected(self, x: Array, read: NDArray[np.bool_]) -> Array:
        """The readings to measure of x, where ``read`` (12,) is True, by the compiled ``measure``."""
        measure(self.record.jaw, x, self.scratch["rows"], self.scratch["expected"])
        return self.scratch["expected"][read].copy()  # type: ignore[no-any-return]

    def rows_by_motion(self, x: Array) -> Array:
        """Derivative (12, n) of all readings by the motion, by the compiled ``measure``."""
        measure(self.record.jaw, x, self.scratch["rows"], self.scratch["expected"])
        return self.scratch["rows"]  # type: ignore[no-any-return]


class NumpyModel(MotionModel):
    """The independent model of ``numpy_model``, for midline jaws: no compiled code, derivatives by complex step."""

    def moved(self, x: Array) -> Array:
        """The state (s,) a tick after x, by ``step_with_derivative``."""
        record, tick = self.record, self.tick
        motion, self.total = step_with_derivative(record.jaw, x, record.samples[tick], self.trends[tick], record.dt)
        return np.concatenate([motion, x[self.n :]])

    def expected(self, x: Array, read: NDArray[np.bool_]) -> Array:
        """The readings to measure of x, where ``read`` (12,) is True, by ``measurement``."""
        return measurement(self.record.jaw, x[: self.n])[read]

    def rows_by_motion(self, x: Array) -> Array:
        """Derivative (12, n) of all readings by the motion, by ``measurement_with_derivative``."""
        return measurement_with_derivative(self.record.jaw, x[: self.n])[1]


class _Extended(ExtendedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter with a model's motion."""

    def __init__(self, model: MotionModel) -> None:
        super().__init__(dim_x=model.size, dim_z=N_MEASUREMENTS)
        self.model = model
        self.x, self.P = initial.initial_belief(model.record)

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
        initial.check_noise("FilterpyExtendedKalman", parameter_rate, parameter_time)
        initial.check_every("FilterpyExtendedKalman", every)
        self.parameter_rate, self.parameter_time, self.every = parameter_rate, parameter_time, every
        self.compiled_model = compiled_model

    def estimate(self, record: Record) -> Estimate:
        """The belief at every ``every``-th tick, the gain error considered; what follows a divergence is NaN."""
        model = (CompiledModel if self.compiled_model else NumpyModel)(record, self.parameter_rate, self.parameter_time)
        kalman, parameters, count = _Extended(model), slice(model.n, model.size - 1), len(record.prior.mean)
        ticks, row = initial.output_ticks(record, self.every), 0
        means, covs = np.full((len(ticks), count), np.nan), np.full((len(ticks), count, count), np.nan)
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
        return Estimate(self.name, record.time[ticks], means, covs)
