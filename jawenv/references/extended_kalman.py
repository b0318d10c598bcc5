"""The plain extended Kalman filter, in logs as a baseline and in F_o and b themselves as in the thesis.

A baseline: unlike the environment's filter (``filter.belief.state``) it carries the parameters in the state and
linearises them at the current mean.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record
from jawenv.references.extended_kalman_kernel import Problem, filter_record
from jawenv.references.initial import initial_belief, output_ticks, parameter_noise, working_memory

Array = NDArray[np.float64]
Scale = Literal["log", "linear"]

SMALLEST = 1e-3  # of a linear parameter over its prior median: below, a muscle is as good as absent


class ExtendedKalman:
    """Textbook extended Kalman filter over motion and parameters, the load cell's gain error considered (Schmidt 1966).

    With ``scale="linear"``, ``parameter_rate=0.01`` and ``parameter_time=math.inf`` it is the filter of Young (2016):
    states F_o and b, with a constant noise that keeps their variance from falling to nothing.

    Args:
        scale: "log" estimates log F_o and log b; "linear" F_o and b. Prior and result are natural logs in either case,
            converted by the delta method: sd of x is x times sd of log x.
        parameter_rate: noise of the parameters, sd per square root of a second at the start; relative, and for
            "linear" to the prior's median. 0 for none.
        parameter_time: time constant of that sd's decay, s; ``math.inf`` for a constant noise.
        every: ticks between the kept estimates; the last is always kept.
    """

    def __init__(
        self, scale: Scale = "log", parameter_rate: float = 0.03, parameter_time: float = 5.0, every: int = 5
    ) -> None:
        if scale not in get_args(Scale):
            raise InputError(f"ExtendedKalman: scale is {scale!r}; allowed: {' and '.join(get_args(Scale))}")
        if not 0.0 <= parameter_rate < np.inf:
            raise InputError(f"ExtendedKalman: parameter_rate is {parameter_rate!r}; allowed: numbers from 0 on")
        if not parameter_time > 0.0:
            raise InputError(
                f"ExtendedKalman: parameter_time is {parameter_time!r}; allowed: numbers above 0, and infinity"
            )
        if every < 1:
            raise InputError(f"ExtendedKalman: every is {every!r}; allowed: whole numbers from 1 on")
        self.scale, self.every = scale, every
        self.parameter_rate, self.parameter_time = parameter_rate, parameter_time
        self.name = f"extended Kalman, {scale}"

    def estimate(self, record: Record) -> Estimate:
        """The belief at every ``every``-th tick; NaN from where the filter has diverged."""
        mean, covariance = initial_belief(record)
        parameters = slice(len(record.start_mean), len(mean) - 1)
        noise = parameter_noise(record, self.parameter_rate, self.parameter_time)
        unit = np.exp(record.prior.mean) if self.scale == "linear" else np.ones(len(record.prior.mean))
        if self.scale == "linear":
            mean[parameters] = unit
            covariance[parameters, parameters] *= np.outer(unit, unit)
        ticks = output_ticks(record, self.every)
        means, cov = run_filter(record, mean, covariance, np.outer(noise, unit**2), ticks, self.scale == "linear")
        values = means[ticks, parameters]
        if self.scale == "linear":
            values = np.maximum(values, SMALLEST * unit)
            cov = cov / (values[:, :, None] * values[:, None, :])
            values = np.log(values)
        return Estimate(self.name, record.time[ticks], values, cov)


def run_filter(
    record: Record, mean: Array, covariance: Array, noise: Array, ticks: NDArray[np.int64], linear: bool = False
) -> tuple[Array, Array]:
    """The compiled filter over a record from any belief about n states, p parameters and the gain error.

    Args:
        record: T ticks.
        mean: (n + p + 1,) before the first reading.
        covariance: (n + p + 1, n + p + 1).
        noise: (T, p) variance that the parameters receive in each tick.
        ticks: (K,) numbers of the times whose covariance is wanted.
        linear: whether the parameters are F_o and b themselves.

    Returns:
        (T + 1, n + p + 1) means at all times, (K, p, p) covariances of the parameters.
    """
    count = len(record.prior.mean)
    means = np.repeat(mean[None], len(record.time), axis=0)
    covariances = np.full((len(ticks), count, count), np.nan)
    problem = Problem(
        jaw=record.jaw,
        measured=record.measured,
        samples=record.samples,
        dt=record.dt,
        variances=record.measurement_sd**2,
        noise_variance=record.noise_variance,
        parameter_noise=noise,
        linear=linear,
        floor=SMALLEST * np.exp(record.prior.mean),
    )
    filter_record(problem, means, covariance.copy(), ticks, covariances, working_memory(record))
    return means, covariances
