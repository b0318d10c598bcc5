"""Observability of motion and parameters by the sensors: rank and Gramian of the linearised problem.

A measurement is worth a row: its derivative by the joint state (n numbers of motion, p log-parameters) at the start of
a window, carried there by the model's own derivative. Each row is divided by its sensor's sd and each column multiplied
by the prior sd of its state, so that all numbers are of one kind: a singular value of s means that the window alone
shrinks the prior's sd along that direction to 1 / sqrt(1 + s^2) of it. Without the scaling, metres and radians per
second would decide the rank. The load cell's gain is taken as right and the unmodelled wrench as none, as usual for
observability; what noise costs is the bound's business.

Young (2016, section 5.4) checks the rank of the observability matrix H, H A, H A^2, ... at points of the maneuver. With
A frozen at one moment the p parameters act through the accelerations alone, n / 2 numbers, so that its rank cannot
exceed 3 n / 2, whatever the sensors: it is the motion that makes the rest observable. Hence both here: ``frozen_rank``
as in the thesis, and the Gramian over windows (Chen 1999, Linear System Theory and Design, section 6.6) with the
derivative as it changes, as singular values of its square root. Noise-free, a numerical rank is soon full: read it with
the singular values, of which those below 1 say little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.analysis.path import MotionPath, path_of
from jawenv.base.errors import InputError
from jawenv.filter.bound.joint_recursion import JointScratch
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.model.joint_step import propagate
from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Observability:
    """Observability of the joint state, m = n + p numbers, in W windows that follow each other.

    A coordinate of motion that is held (prior sd 0) is known, and counts neither as state nor in the ranks.
    """

    start: Array  # (W,) s, when each window begins
    window_s: float  # length of a window, s
    states: int  # free numbers of motion and parameters: the largest possible rank
    singular_values: Array  # (W, states) of the scaled rows of each window, largest first
    growing_rank: NDArray[np.intp]  # (W,) rank of all rows from the record's start to the end of each window
    frozen_rank: NDArray[np.intp]  # (W,) rank of the observability matrix with A frozen at the start of each window

    @property
    def rank(self) -> NDArray[np.intp]:
        """(W,) numerical rank of each window: singular values that rounding does not explain."""
        return np.array([numerical_rank(values) for values in self.singular_values])


@njit
def _linearise_path(path: MotionPath, by_state, by_parameter, rows):
    """Derivatives along a ``MotionPath``: ``by_state`` (T, n, n), ``by_parameter`` (T, n, p), ``rows`` (T + 1, 12, n).

    ``rows`` are over the sensors' sds, and zero where nothing was read.
    """
    states, scratch = path.states, path.scratch
    n_states, parameters = states.shape[1], by_parameter.shape[2]
    state, trend = np.empty(n_states), np.zeros(N_WRENCH)
    for tick in range(rows.shape[0]):
        measure(path.jaw, states[tick], scratch.rows, scratch.expected)
        for i in range(rows.shape[1]):
            weight = path.used[tick, i] / np.sqrt(path.measurement_variance[i])
            for j in range(n_states):
                rows[tick, i, j] = weight * scratch.rows[i, j]
        if tick < path.wrenches.shape[0]:
            state[:] = states[tick]
            propagate(path.jaw, path.muscles, state, path.wrenches[tick], trend, 0.0, path.dt, scratch)
            for i in range(n_states):
                for j in range(n_states):
                    by_state[tick, i, j] = scratch.total[i, j]
                for j in range(parameters):
                    by_parameter[tick, i, j] = scratch.total[i, n_states + j]


def derivatives(path: MotionPath) -> tuple[Array, Array, Array]:
    """Derivatives of each tick's step by motion (T, n, n) and parameters (T, n, p), whitened rows (T + 1, 12, n)."""
    ticks, n_states = len(path.wrenches), path.states.shape[1]
    parameters = path.covariance.shape[0] - n_states - 1
    by_state, by_parameter = np.empty((ticks, n_states, n_states)), np.empty((ticks, n_states, parameters))
    rows = np.empty((ticks + 1, N_MEASUREMENTS, n_states))
    _linearise_path(path, by_state, by_parameter, rows)
    return by_state, by_parameter, rows


def numerical_rank(singular_values: Array) -> int:
    """Values above rounding: the number of columns times the machine's epsilon times the largest, as is usual."""
    return int((singular_values > singular_values.max() * len(singular_values) * np.finfo(float).eps).sum())


def reduced(rows: Array) -> Array:
    """A square triangle with the same singular values as ``rows`` (k, m)."""
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)


@njit
def _rates_at(jaw: Jaw, muscles, state, wrench, trend, moving, rates, scratch: JointScratch):
    """Derivative (n, n + p) of the motion's rate by motion and parameters at one moment, into ``rates``.

    ``moving`` (n) is a copy of ``state`` to work in. It is what a step of no length leaves in ``scratch.slope``.
    """
    moving[:] = state
    propagate(jaw, muscles, moving, wrench, trend, 0.0, 0.0, scratch)
    for i in range(rates.shape[0]):
        for j in range(rates.shape[1]):
            rates[i, j] = scratch.slope[i, j]


def frozen_rank(path: MotionPath, rows: Array, tick: int, scale: Array) -> int:
    """Rank of H, H A, H A^2, ... with A frozen at the start of a tick, columns scaled by ``scale`` (m,)."""
    size, n_states = len(scale), path.states.shape[1]
    joint, trend = np.zeros((size, size)), np.zeros(N_WRENCH)
    rates = np.empty((n_states, size))
    _rates_at(
        path.jaw, path.muscles, path.states[tick], path.wrenches[tick], trend, np.empty(n_states), rates, path.scratch
    )
    # In units of the states' prior sds, and of a time in which all powers of A are of one size.
    unit = np.where(scale > 0.0, scale, 1.0)
    joint[:n_states] = rates * scale / unit[:n_states, None]
    joint /= np.linalg.norm(joint, 2)
    block = np.hstack([rows, np.zeros((len(rows), size - n_states))]) * scale
    blocks = []
    for _ in range(size):
        # Rows of length 1: only their directions count.
        length = np.linalg.norm(block, axis=1, keepdims=True)
        block = block / np.where(length > 0.0, length, 1.0)
        blocks.append(block)
        block = block @ joint
    return numerical_rank(singular_values(np.vstack(blocks)[:, scale > 0.0], int((scale > 0.0).sum())))


def _step_back(carried: Array, by_state: Array, by_parameter: Array) -> Array:
    """Derivative (n, m) of the motion by the joint state at the window's start, one tick later."""
    later = by_state @ carried
    later[:, len(by_state) :] += by_parameter
    return later


def observability(record: Record, parameters: Array | None = None, window_s: float = 1.0) -> Observability:
    """Rank and scaled singular values of a record's joint problem, window by window.

    Args:
        record: with ``states``, see ``bound.bound_along``.
        parameters: (p,) natural-log parameters; None for the record's ``truth``.
        window_s: length of a window, s; what is left over at the record's end is not looked at.
    """
    ticks_each = round(window_s / record.dt) if np.isfinite(window_s) else 0
    ticks = len(record.time) - 1
    if not 1 <= ticks_each <= ticks:
        raise InputError(f"window_s is {window_s}; allowed: {record.dt:g} to {ticks * record.dt:g} s")
    path = path_of(record, parameters)
    by_state, by_parameter, rows = derivatives(path)
    scale = np.asarray(np.sqrt(np.diag(path.covariance))[:-1], dtype=np.float64)
    free, n_states = scale > 0.0, path.states.shape[1]
    starts = np.arange(0, ticks - ticks_each + 1, ticks_each)
    values, growing, frozen_ranks = [], [], []
    from_start, triangle_from_start = np.eye(n_states, len(scale)), np.zeros((0, int(free.sum())))
    for start in starts:
        carried, blocks, blocks_from_start = np.eye(n_states, len(scale)), [], []
        for tick in range(start, start + ticks_each):
            blocks.append(rows[tick] @ carried)
            blocks_from_start.append(rows[tick] @ from_start)
            carried = _step_back(carried, by_state[tick], by_parameter[tick])
            from_start = _step_back(from_start, by_state[tick], by_parameter[tick])
        last = rows[start + ticks_each]
        triangle = reduced((np.vstack([*blocks, last @ carried]) * scale)[:, free])
        values.append(singular_values(triangle, int(free.sum())))
        triangle_from_start = reduced(
            np.vstack([triangle_from_start, (np.vstack([*blocks_from_start, last @ from_start]) * scale)[:, free]])
        )
        growing.append(numerical_rank(singular_values(triangle_from_start, int(free.sum()))))
        frozen_ranks.append(frozen_rank(path, rows[start], int(start), scale))
    return Observability(
        start=record.time[starts],
        window_s=ticks_each * record.dt,
        states=int(free.sum()),
        singular_values=np.array(values),
        growing_rank=np.array(growing),
        frozen_rank=np.array(frozen_ranks),
    )


def singular_values(rows: Array, size: int) -> Array:
    """(size,) singular values, zeros where there are fewer rows."""
    values = np.linalg.svd(rows, compute_uv=False)
    return np.concatenate([values, np.zeros(size - len(values))])
