"""Kernels of the smoother: the least-squares problem of a whole record about one path, and the rolling out of paths.

A *path* is a motion x_0, ..., x_T that the model makes exactly: x_k+1 = f(x_k, parameters, readings_k + w_k), with the
unknown wrench w_k, a part constant over a tick and a linear one (``joint_step``). Linearised about a path,
the problem is solved exactly by a Kalman filter forward and the adjoint recursion of Bryson & Frazier backward (Bierman
1977, Factorization Methods for Discrete Sequential Estimation, chapter 10). That inverts no covariance.

The number of parts of each tick is fixed, unlike the filters', where it depends on the state: otherwise the cost would
be discontinuous where that number changes, and the search would stall.

Sizes: T ticks, n states of motion, p log-parameters, s = n + p + 1 with the load cell's gain error, which stays 0 here.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.bound.joint_recursion import (
    JointScratch,
    innovation_variance,
    joint_scratch_dtype,
    predict_covariance,
)
from jawenv.filter.model.encoders import N_MEASUREMENTS, expect
from jawenv.filter.model.joint_step import N_NOISE, N_SAMPLES, copy_matrix, propagate_in, set_muscles, step_parts
from jawenv.kernels.cholesky import solve_decomposed
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import decompose
from jawenv.kernels.records import record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.references.extended_kalman_kernel import reduce_covariance

Array = NDArray[np.float64]


class _Sweep:
    """The forward sweep's results at one time, for the backward sweep."""

    total: Annotated[Array, "states", "columns"]  # derivative of the tick that ends at this time
    rows: Annotated[Array, N_MEASUREMENTS, "states"]
    gains: Annotated[Array, N_MEASUREMENTS, "size"]  # P h of each scalar reading
    variance: Annotated[Array, N_MEASUREMENTS]  # of its innovation; 0 if it was not read
    innovation: Annotated[Array, N_MEASUREMENTS]
    mean: Annotated[Array, "size"]  # of the deviation, after the readings
    covariance: Annotated[Array, "states", "size"]


@cache
def sweep_dtype(n_states: int, n_parameters: int) -> np.dtype[np.void]:
    """Dtype of ``_Sweep``."""
    size = n_states + n_parameters + 1
    return record_dtype(_Sweep, states=n_states, columns=size + N_NOISE, size=size)


class _PathScratch:
    """The working memory of this file's kernels."""

    filter: JointScratch
    pushed: Annotated[Array, N_SAMPLES, N_WRENCH]
    before: Annotated[Array, "size"]
    adjoint: Annotated[Array, "size"]
    matrix: Annotated[Array, "states", "states"]
    right: Annotated[Array, "states"]


@cache
def path_scratch_dtype(n_muscles: int, n_lines: int, n_states: int) -> np.dtype[np.void]:
    """Dtype of ``_PathScratch``."""
    size = n_states + 2 * n_muscles + 1
    return record_dtype(
        _PathScratch, filter=joint_scratch_dtype(n_muscles, n_lines, n_states), size=size, states=n_states
    )


class PathProblem(NamedTuple):
    """A record of T ticks as a least-squares problem; all that the kernels only read."""

    jaw: Any  # record of dtype ``jaw_dtype``
    measured: Array  # (T + 1, 12); NaN was not read
    samples: Array  # (T, 3, 6) of the load cell
    trends: Array  # (T, 6) of the load cell, at the start of each tick
    dt: float  # s
    parts: NDArray[np.int64]  # (T,) into how many parts each tick is divided
    variances: Array  # (12,) of the encoders
    wrench_variances: Array  # (T, 12) of the unknown wrenches
    tolerance: Array  # (n,) variances within which a motion wanted is kept


@njit
def divide(jaw: Jaw, states, parameters, dt, parts, scratch: _PathScratch):
    """Raise ``parts`` (T,) to what the motion ``states`` (T + 1, n) asks for; whether any was raised."""
    inner, raised = scratch.filter, False
    set_muscles(jaw, parameters, 0, inner.muscles)
    for k in range(parts.shape[0]):
        needed = step_parts(jaw, inner.muscles, states[k], dt, inner.linear)
        if needed > parts[k]:
            parts[k], raised = needed, True
    return raised


@njit
def push(problem: PathProblem, k, state, wrench, scratch: _PathScratch):
    """Move ``state`` (n) over tick k under its readings and ``wrench`` (12); leaves the derivative in the scratch."""
    jaw, samples = problem.jaw, problem.samples[k]
    for i in range(samples.shape[0]):
        for j in range(N_WRENCH):
            scratch.pushed[i, j] = samples[i, j] + wrench[j] + (i - 1.0) * wrench[N_WRENCH + j]
    inner, cell = scratch.filter, (scratch.pushed, problem.trends[k], 0.0)
    propagate_in(jaw, inner.muscles, state, cell, problem.dt, problem.parts[k], inner)


@njit
def carry(total, vector, before):
    """``vector`` (s) <- F ``vector`` with F's upper rows in ``total``; ``before`` (s) is scratch."""
    for j in range(vector.shape[0]):
        before[j] = vector[j]
    for i in range(total.shape[0]):
        vector[i] = 0.0
        for j in range(before.shape[0]):
            vector[i] += total[i, j] * before[j]


@njit
def take_readings(problem: PathProblem, k, state, mean, covariance, considered, sweep: _Sweep, scratch: JointScratch):
    """Update of the deviation's belief with the readings at time k, linearised at ``state``."""
    measured, variances = problem.measured[k], problem.variances
    expect(problem.jaw, state, sweep.rows, scratch.expected)
    for i in range(N_MEASUREMENTS):
        sweep.variance[i] = 0.0
        if measured[i] != measured[i]:
            continue
        row, gains = sweep.rows[i], sweep.gains[i]
        variance = innovation_variance(covariance, row, variances[i], gains)
        innovation, gain_effect = measured[i] - scratch.expected[i], 0.0
        for j in range(row.shape[0]):
            innovation -= row[j] * mean[j]
            gain_effect += row[j] * considered[j]
        reduce_covariance(covariance, gains, variance)
        for j in range(mean.shape[0]):
            mean[j] += innovation / variance * gains[j]
            considered[j] -= gain_effect / variance * gains[j]
        sweep.variance[i], sweep.innovation[i] = variance, innovation


@njit
def sweep_forward(problem: PathProblem, states, wrenches, mean, covariance, considered, sweeps, scratch: _PathScratch):
    """Filter the deviations from a path forward in time.

    Args:
        problem: See ``PathProblem``.
        states: (T + 1, n) motion of the path.
        wrenches: (T, 12) wrenches of the path.
        mean: (s,) of the deviation before the first reading; changed to that after the last.
        covariance: (s, s) likewise, with zeros for the gain error.
        considered: (s,) derivative of the true deviation minus ``mean`` by the gain error; likewise.
        sweeps: (T + 1,) records of dtype ``sweep_dtype``, with the path's derivatives as ``roll_out`` leaves them; the
            rest is filled.
        scratch: Working memory.
    """
    n_states, size = states.shape[1], mean.shape[0]
    inner = scratch.filter
    for k in range(states.shape[0]):
        sweep = sweeps[k]
        if k > 0:
            copy_matrix(inner.total, sweep.total)
            carry(inner.total, mean, scratch.before)
            carry(inner.total, considered, scratch.before)
            for i in range(n_states):
                for j in range(N_NOISE):
                    mean[i] -= inner.total[i, size + j] * wrenches[k - 1, j]
            for j in range(N_NOISE):
                inner.noise_variance[j] = problem.wrench_variances[k - 1, j]
            predict_covariance(covariance, inner.noise_variance, inner)
        take_readings(problem, k, states[k], mean, covariance, considered, sweep, inner)
        for j in range(size):
            sweep.mean[j] = mean[j]
            for i in range(n_states):
                sweep.covariance[i, j] = covariance[i, j]


@njit
def sweep_backward(wrench_variances, sweeps, to_states, to_wrenches, scratch: _PathScratch):
    """The least-squares motion (T + 1, n), as deviation from the path, and the wrenches (T, 12) that go with it."""
    n_states, size = to_states.shape[1], scratch.adjoint.shape[0]
    adjoint = scratch.adjoint
    for j in range(size):
        adjoint[j] = 0.0
    for k in range(to_states.shape[0] - 1, -1, -1):
        sweep = sweeps[k]
        for i in range(n_states):
            to_states[k, i] = sweep.mean[i]
            for j in range(size):
                to_states[k, i] -= sweep.covariance[i, j] * adjoint[j]
        for i in range(N_MEASUREMENTS - 1, -1, -1):
            if sweep.variance[i] > 0.0:
                weight = sweep.innovation[i]
                for j in range(size):
                    weight += sweep.gains[i, j] * adjoint[j]
                for j in range(n_states):
                    adjoint[j] -= sweep.rows[i, j] * weight / sweep.variance[i]
        if k == 0:
            break
        for j in range(N_NOISE):
            to_wrenches[k - 1, j] = 0.0
            for i in range(n_states):
                to_wrenches[k - 1, j] -= wrench_variances[k - 1, j] * sweep.total[i, size + j] * adjoint[i]
        for j in range(size):
            scratch.before[j] = 0.0 if j < n_states else adjoint[j]
            for i in range(n_states):
                scratch.before[j] += sweep.total[i, j] * adjoint[i]
        for j in range(size):
            adjoint[j] = scratch.before[j]


@njit
def steer(total, missed, wrench_variance, tolerance, wrench, scratch: _PathScratch):
    """Add to ``wrench`` (12) what brings a state that ``missed`` its target by so much (n) back, as far as it pays.

    The most probable wrench for a miss that is observed with variances ``tolerance`` (n).
    """
    n_states, matrix, right = missed.shape[0], scratch.matrix, scratch.right
    first = total.shape[1] - N_NOISE
    for i in range(n_states):
        right[i] = missed[i]
        for j in range(n_states):
            matrix[i, j] = tolerance[i] if i == j else 0.0
            for k in range(N_NOISE):
                matrix[i, j] += total[i, first + k] * wrench_variance[k] * total[j, first + k]
    decompose(matrix)
    solve_decomposed(matrix, right)
    for k in range(N_NOISE):
        for i in range(n_states):
            wrench[k] += wrench_variance[k] * total[i, first + k] * right[i]


@njit
def _cost_of_readings(problem: PathProblem, k, state, scratch: JointScratch):
    """Half the squared misfit of the readings at time k, in sds."""
    measured, variances = problem.measured[k], problem.variances
    expect(problem.jaw, state, scratch.rows, scratch.expected)
    cost = 0.0
    for i in range(N_MEASUREMENTS):
        if measured[i] == measured[i]:
            miss = measured[i] - scratch.expected[i]
            cost += 0.5 * miss * miss / variances[i]
    return cost


@njit
def roll_out(problem: PathProblem, states, wrenches, parameters, sweeps, scratch: _PathScratch):
    """Turn a motion that the model would not make into a path close to it; the cost of its readings and wrenches.

    Without steering, a change of the parameters by a few per cent moves the end of a long path far away, however well
    the wrenches fit to the first order.

    Args:
        problem: See ``PathProblem``.
        states: (T + 1, n) the motion wanted; row 0 is taken as it is, the others become those of the path.
        wrenches: (T, 12) the wrenches wanted, likewise.
        parameters: (p,) logs.
        sweeps: (T + 1,) records of dtype ``sweep_dtype``; their ``total`` becomes the path's.
        scratch: Working memory.

    Returns:
        Half the sum of squares of the readings' misfits and of the wrenches, in sds.
    """
    n_states, inner, wrench_variances = states.shape[1], scratch.filter, problem.wrench_variances
    set_muscles(problem.jaw, parameters, 0, inner.muscles)
    cost = _cost_of_readings(problem, 0, states[0], inner)
    for k in range(wrenches.shape[0]):
        wrench = wrenches[k]
        for i in range(n_states):
            inner.state[i] = states[k, i]
        push(problem, k, inner.state, wrench, scratch)
        for i in range(n_states):
            inner.row[i] = states[k + 1, i] - inner.state[i]
        steer(inner.total, inner.row, wrench_variances[k], problem.tolerance, wrench, scratch)
        for i in range(n_states):
            states[k + 1, i] = states[k, i]
        push(problem, k, states[k + 1], wrench, scratch)
        copy_matrix(sweeps[k + 1].total, inner.total)
        for j in range(N_NOISE):
            if wrench_variances[k, j] > 0.0:
                cost += 0.5 * wrench[j] * wrench[j] / wrench_variances[k, j]
        cost += _cost_of_readings(problem, k + 1, states[k + 1], inner)
        if not np.isfinite(cost):
            return cost
    return cost
