"""Maximum a posteriori from a whole record at once: the reference for the filters.

First the most probable path. Unknowns are the motion before the first reading, the parameters, and the unknown wrench
of every tick. The cost is half the sum of squares, in sds, of readings' misfits, wrenches, and departures from the
prior; its minimum is the mode of the posterior. Gauss-Newton on all of them at once is the Kalman smoother iterated
about its own path (Bell 1994, SIAM J. Optim. 4:626). Parameters are constants here, without the noise that filters give
them.

Then the most probable parameters, whatever the motion. The two differ, as wherever there are as many unknowns as
readings (Neyman & Scott 1948, Econometrica 16:1): the cost of a path prefers parameters that make the variance of the
innovations large, and takes the load cell's noise for force. Under ``chirp`` and ``prbs`` the errors of the path's
parameters are 1.28 times the bound, those of the most probable ones 1.07 and 0.99 times (48 patients, 30 s). The
motion has to be integrated out (``mode_search``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.filter.model.joint_step import N_NOISE
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record
from jawenv.references.extended_kalman import ExtendedKalman, run_filter
from jawenv.references.initial import initial_belief, trends
from jawenv.references.mode_search import integrate_out
from jawenv.references.whole_path import (
    PathProblem,
    divide,
    path_scratch_dtype,
    roll_out,
    sweep_backward,
    sweep_dtype,
    sweep_forward,
)

Array = NDArray[np.float64]

SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0
REACH = 4.0  # prior sds within which the search begins
# How close a path follows the motion wanted: a tenth of what is known before the first reading, back within two ticks.
CLOSE, TICKS_BACK = 0.1, 2.0
SMALLEST_STEP = 1e-4  # of a Gauss-Newton step


@dataclass(frozen=True, eq=False)
class _SmoothedPath:
    """A motion that the model makes exactly."""

    states: Array  # (T + 1, n)
    wrenches: Array  # (T, 12) unknown wrench of each tick, N and N m: constant over it, and tilting from -1 to 1
    parameters: Array  # (p,) natural logs
    cost: float  # half the sum of squares, in sds


@dataclass(frozen=True, eq=False)
class _FoundPath:
    """The most probable path."""

    path: _SmoothedPath  # it
    path_cov: Array
    """(p, p) of its parameters: inverse of the Gauss-Newton Hessian, with the load cell's gain error considered."""
    costs: tuple[float, ...]
    """Of every path on the way, the first included, since the model's steps were last divided anew."""
    step: float  # largest change of a parameter that the last step asked for, in posterior sds
    converged: bool  # whether that is within the tolerance


@dataclass(frozen=True, eq=False)
class _Smoothed(_FoundPath):
    """The most probable path, and the parameters whatever the motion."""

    mean: Array  # (p,) of the natural-log parameters, the motion integrated out
    cov: Array  # (p, p) of them


class IteratedSmoother:
    """Maximum a posteriori over a whole record: Gauss-Newton with step halving, then the parameters alone.

    The model divides its steps where the jaw is stiff, on its teeth above all. They stay divided as the paths on the
    way asked for, so that the cost has no jumps in which the search would end.

    Along the path the load cell's gain error is considered: the path is that for a gain error of 0, and what one of
    ``record.gain_sd`` would do to it is added to its covariance. The parameters' likelihood has it integrated out.

    Where a record says little the posterior is not normal: mean and covariance are those of posterior linearisation
    (``posterior``), as the filter's are; the path's are its mode and tangents. Where a condyle lifts off its disc the
    cost has a kink, and the minimum may lie in one: the search then ends without convergence, a fraction of an sd away
    from where the tangents would have it.

    Args:
        max_iterations: of Gauss-Newton.
        tolerance: largest step of a parameter, in its posterior sds, at which the search ends.
        times: s, ends of the shortened records to estimate from; None for the whole record alone.
    """

    name = "iterated smoother"

    def __init__(
        self, max_iterations: int = 30, tolerance: float = 1e-3, times: tuple[float, ...] | None = None
    ) -> None:
        if max_iterations < 1:
            raise InputError(f"IteratedSmoother: max_iterations is {max_iterations!r}; allowed: 1 and more")
        if not tolerance > 0.0:
            raise InputError(f"IteratedSmoother: tolerance is {tolerance!r}; allowed: numbers above 0")
        if times is not None and (len(times) == 0 or not (np.diff(times, prepend=0.0) > 0.0).all()):
            raise InputError(f"IteratedSmoother: times is {times!r}; allowed: growing numbers above 0")
        self.max_iterations, self.tolerance, self.times = max_iterations, tolerance, times

    def estimate(self, record: Record) -> Estimate:
        """The belief at ``times``, each from the record until then alone."""
        records = [record] if self.times is None else [record.until(time) for time in self.times]
        results = [self.smooth(part) for part in records]
        return Estimate(
            self.name,
            np.array([part.time[-1] for part in records]),
            np.array([result.mean for result in results]),
            np.array([result.cov for result in results]),
        )

    def smooth(self, record: Record) -> _Smoothed:
        """The most probable path of a record, and from there the parameters."""
        result = self.find_path(record)
        mean, cov = integrate_out(record, result.path.parameters)
        return _Smoothed(result.path, result.path_cov, result.costs, result.step, result.converged, mean, cov)

    def find_path(self, record: Record) -> _FoundPath:
        """The most probable path of a record: motion and parameters together.

        The search begins at the extended Kalman filter's last estimate. Each step is halved until the cost falls; if no
        step makes it fall, the path before is returned, as not converged.
        """
        problem = _Problem(record)
        path = problem.first_path()
        costs = [path.cost]
        for _ in range(self.max_iterations):
            step, cov = problem.gauss_newton(path)
            better = problem.search(path, step)
            if better is not None:
                path = better
                costs.append(path.cost)
            size = float((np.abs(step.parameters) / np.sqrt(np.diag(cov))).max())
            if problem.divide(path):
                path = problem.path(path.states.copy(), path.wrenches.copy(), path.parameters)
                costs = [path.cost]
            elif size <= self.tolerance or better is None:
                break
        return _FoundPath(path, cov, tuple(costs), size, size <= self.tolerance)


class _Problem:
    """One record's least-squares problem, with the memory that its sweeps need."""

    def __init__(self, record: Record) -> None:
        self.record = record
        self.n, self.p = len(record.start_mean), len(record.prior.mean)
        self.mean, covariance = initial_belief(record)
        self.sd = np.sqrt(np.diag(covariance))
        self.sd[-1] = 0.0
        trend = trends(record)
        fast = np.einsum("i,tik->tk", SIMPSON, record.samples) - trend
        wrench_variances = np.tile(record.noise_variance, (len(record.samples), 1))
        wrench_variances[:, :N_WRENCH] += record.gain_sd**2 * fast**2
        self.sweeps = record_zeros(len(record.time), sweep_dtype(self.n, self.p))
        self.scratch: Any = record_zeros(1, path_scratch_dtype(self.p // 2, len(record.jaw["l_o"]), self.n))[0]
        position_sd = CLOSE * record.start_sd[: self.n // 2]
        tolerance = np.concatenate([position_sd, position_sd / (TICKS_BACK * record.dt)]) ** 2
        # A coordinate that is held misses nothing; any positive number keeps the steering's matrix regular.
        self.arrays = PathProblem(
            jaw=record.jaw,
            measured=record.measured,
            samples=record.samples,
            trends=trend,
            dt=record.dt,
            parts=np.ones(len(record.samples), dtype=np.int64),
            variances=record.measurement_sd**2,
            wrench_variances=wrench_variances,
            tolerance=np.where(tolerance > 0.0, tolerance, 1.0),
        )

    def first_path(self) -> _SmoothedPath:
        """A path through the filtered motion, with the parameters that the extended Kalman filter ends with."""
        record, prior = self.record, self.record.prior
        estimate = ExtendedKalman().estimate(record).mean[-1]
        estimate = np.where(np.isfinite(estimate), estimate, prior.mean)
        parameters = np.clip(estimate, prior.mean - REACH * prior.sd, prior.mean + REACH * prior.sd)
        mean, covariance = initial_belief(record)
        mean[self.n : -1] = parameters
        motion_covariance = np.diag(np.where(np.arange(len(mean)) < self.n, np.diag(covariance), 0.0))
        no_noise = np.zeros((len(record.samples), self.p))
        means, _ = run_filter(record, mean, motion_covariance, no_noise, np.empty(0, dtype=np.int64))
        states = means[:, : self.n].copy()
        divide(record.jaw, states, parameters, record.dt, self.arrays.parts, self.scratch)
        return self.path(states, np.zeros((len(record.samples), N_NOISE)), parameters)

    def divide(self, path: _SmoothedPath) -> bool:
        """Divide the steps as finely as a path asks for; whether any is finer than before, and so the cost another."""
        record = self.record
        return bool(divide(record.jaw, path.states, path.parameters, record.dt, self.arrays.parts, self.scratch))

    def path(self, states: Array, wrenches: Array, parameters: Array) -> _SmoothedPath:
        """The path near a motion, which is overwritten."""
        cost = roll_out(self.arrays, states, wrenches, parameters, self.sweeps, self.scratch)
        deviation = np.concatenate([states[0], parameters, [0.0]]) - self.mean
        free = self.sd > 0.0
        return _SmoothedPath(
            states, wrenches, parameters, float(cost + 0.5 * np.sum((deviation[free] / self.sd[free]) ** 2))
        )

    def gauss_newton(self, path: _SmoothedPath) -> tuple[_SmoothedPath, Array]:
        """The step to the minimum of the linearised problem, and the covariance of the parameters there.

        The path is the one that was made last, whose derivatives are kept.
        """
        mean = self.mean - np.concatenate([path.states[0], path.parameters, [0.0]])
        covariance, considered = np.diag(self.sd**2), np.zeros(len(mean))
        considered[-1] = 1.0
        sweep_forward(self.arrays, path.states, path.wrenches, mean, covariance, considered, self.sweeps, self.scratch)
        to_states, wrenches = np.empty_like(path.states), np.empty_like(path.wrenches)
        sweep_backward(self.arrays.wrench_variances, self.sweeps, to_states, wrenches, self.scratch)
        parameters = slice(self.n, self.n + self.p)
        by_gain = considered[parameters]
        cov = covariance[parameters, parameters] + self.record.gain_sd**2 * np.outer(by_gain, by_gain)
        return _SmoothedPath(to_states, wrenches - path.wrenches, mean[parameters], np.nan), cov

    def search(self, path: _SmoothedPath, step: _SmoothedPath) -> _SmoothedPath | None:
        """The path after the longest of the halved steps that lets the cost fall."""
        share = 1.0
        while share >= SMALLEST_STEP:
            candidate = self.path(
                path.states + share * step.states,
                path.wrenches + share * step.wrenches,
                path.parameters + share * step.parameters,
            )
            if candidate.cost < path.cost:
                return candidate
            share *= 0.5
        return None
