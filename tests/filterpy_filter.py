"""filterpy's extended Kalman filter on the model of ``numpy_model``, which shares no kernel with ``ExtendedKalman``.

Equal results verify model, derivative and filter. The state is that of ``joint_recursion``: motion, natural-log
parameters, gain error of the load cell. The noise of the motion is G W G^T, with the wrench's variance W and its effect
G taken at the mean. The gain error is a considered parameter (Schmidt 1966): after the optimal update its mean and
variance are restored.
"""

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from newton_euler import measurement
from numpy_model import mean_readings, measurement_with_derivative, step_with_derivative, trends

from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_NOISE
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH
from jawenv.recordings.estimate import Estimate
from jawenv.references import initial


class FilterpyExtendedKalman:
    """The numbers of ``ExtendedKalman`` in logs, with the same arguments; for midline jaws, and slow."""

    def __init__(self, parameter_rate=0.03, parameter_time=5.0, every=5):
        self.noise, self.every = (parameter_rate, parameter_time), every

    def estimate(self, record):
        """The belief at every ``every``-th tick."""
        kalman, count = _Kalman(record, initial.parameter_noise(record, *self.noise)), len(record.prior.mean)
        ticks, parameters = initial.output_ticks(record, self.every), slice(N_STATES, N_STATES + count)
        means, covs = np.empty((len(ticks), count)), np.empty((len(ticks), count, count))
        for k in range(len(record.time)):
            if k > 0:
                kalman.tick = k - 1
                kalman.predict()
            kalman.take(k)
            for row in np.flatnonzero(ticks == k):
                means[row], covs[row] = kalman.x[parameters], kalman.P[parameters, parameters]
        return Estimate("filterpy", record.time[ticks], means, covs)


class _Kalman(ExtendedKalmanFilter):
    """filterpy's filter with the model of a record; ``noise`` (T,) is the parameters' variance in each tick."""

    def __init__(self, record, noise):
        mean, covariance = initial.initial_belief(record)
        super().__init__(dim_x=len(mean), dim_z=N_MEASUREMENTS)
        self.x, self.P = mean, covariance
        self.record, self.noise, self.tick = record, noise, 0
        self.trends = trends(record)
        self.fast = mean_readings(record) - self.trends

    def predict_x(self, u=0):
        """Move the mean; filterpy takes F and Q afterwards."""
        record, tick, n = self.record, self.tick, N_STATES
        motion, total = step_with_derivative(record.jaw, self.x, record.samples[tick], self.trends[tick], record.dt)
        self.x = np.concatenate([motion, self.x[n:]])
        self.F = np.eye(self.dim_x)
        self.F[:n] = total[:, :-N_NOISE]
        variance, by_noise = record.noise_variance, total[:, -N_NOISE:]
        variance[:N_WRENCH] += self.P[-1, -1] * self.fast[tick] ** 2
        of_parameters = np.full(len(record.prior.mean), self.noise[tick])
        self.Q = np.diag(np.concatenate([np.zeros(n), of_parameters, [0.0]]))
        self.Q[:n, :n] = (by_noise * variance) @ by_noise.T

    def take(self, k):
        """Update with the readings at time k, if there are any."""
        measured, jaw = self.record.measured[k], self.record.jaw
        read = np.isfinite(measured)
        if not read.any():
            return

        def rows(x):
            by_state = np.zeros((N_MEASUREMENTS, self.dim_x))
            by_state[:, :N_STATES] = measurement_with_derivative(jaw, x[:N_STATES])[1]
            return by_state[read]

        considered = self.x[-1], self.P[-1, -1]
        variances = np.diag(self.record.measurement_sd[read] ** 2)
        self.update(measured[read], rows, lambda x: measurement(jaw, x[:N_STATES])[read], variances)
        self.x[-1], self.P[-1, -1] = considered
