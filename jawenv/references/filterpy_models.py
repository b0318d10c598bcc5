"""The filters' model as filterpy asks for it: functions of a state vector, compiled or in plain NumPy."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.model.joint_step import N_NOISE, propagate, set_muscles
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.newton_euler import measurement
from jawenv.recordings.record import Record
from jawenv.references.initial import mean_readings, parameter_noise, trends, working_memory
from jawenv.references.numpy_model import measurement_with_derivative, step_with_derivative

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
        self.noise = parameter_noise(record, parameter_rate, parameter_time)
        self.trends = trends(record)
        self.fast = mean_readings(record) - self.trends
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
        self.scratch = working_memory(record)
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
