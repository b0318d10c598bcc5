"""The bound's recursion over one tick along a known motion, with all that is uncertain beside the muscles.

State: motion (n); the unmodelled wrench where it has memory (6, ``disturbance``); nuisances in prior sds (q,
``nuisances``); natural logs of F_o and b per muscle; the load cell's relative gain error (1). Where anatomy and device
are known exactly and the wrench has no memory this is ``joint_recursion``'s own state.

A nuisance is a constant with prior N(0, 1) that is estimated with the rest (``with_nuisances``, which is loaded where
there are some).
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.filter.belief.state import FilterSettings, joint_size
from jawenv.filter.bound.joint_recursion import (
    JointScratch,
    Recursion,
    joint_scratch_dtype,
    predict_covariance,
    recursion_dtype,
    take_rows,
)
from jawenv.filter.bound.joint_step import propagate
from jawenv.filter.model.encoders import measure
from jawenv.filter.model.motion_step import N_NOISE
from jawenv.filter.nuisances.if_any import NuisanceScratch, nuisance_scratch_dtype
from jawenv.filter.updates.disturbance import set_total
from jawenv.kernels.compiled import njit, where
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw

_NUISANCES = "jawenv.filter.bound.with_nuisances"


class BoundScratch:
    """One thread's working memory."""

    joint: JointScratch
    recursion: Recursion
    nuisances: NuisanceScratch
    wrench: Annotated[Array, N_WRENCH, "unknown"]  # of one sd of each nuisance
    matrix: Annotated[Array, "parameters", "parameters"]


@cache
def bound_scratch_dtype(
    n_muscles: int, n_lines: int, n_states: int, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of ``BoundScratch``."""
    moving, size = n_states + n_disturbance, joint_size(n_muscles, n_states, n_nuisances, n_disturbance)
    return record_dtype(
        BoundScratch,
        joint=joint_scratch_dtype(n_muscles, n_lines, n_states),
        recursion=recursion_dtype(moving, moving + n_nuisances, size),
        nuisances=nuisance_scratch_dtype(n_lines, n_nuisances),
        unknown=n_nuisances,
        parameters=2 * n_muscles,
    )


@njit
def first_parameter(covariance, settings: FilterSettings):
    """Number of the first log-parameter among the states."""
    return covariance.shape[0] - 1 - settings.prior_sd.shape[0]


@njit
def begin_bound(settings: FilterSettings, covariance):
    """The joint prior, from the filter's ``settings``."""
    first, moving = first_parameter(covariance, settings), settings.start_sd.shape[0]
    covariance[:, :] = 0.0
    for i in range(moving):
        covariance[i, i] = settings.start_sd[i] * settings.start_sd[i]
    for i in range(moving, first):
        covariance[i, i] = 0.0 if settings.nuisances.again[i - moving] else 1.0
    for i in range(settings.prior_sd.shape[0]):
        covariance[first + i, first + i] = settings.prior_sd[i] * settings.prior_sd[i]
    covariance[-1, -1] = settings.gain_variance


@njit
def move_bound(jaw: Jaw, covariance, tick, settings: FilterSettings, noise_variance, scratch: BoundScratch):
    """Through a tick; ``tick`` is (muscles, motion before and after, wrench, cell's trend, friction), all true."""
    muscles, before, after, wrench, trend, friction = tick
    joint, recursion = scratch.joint, scratch.recursion
    joint.state[:] = before
    propagate(jaw, muscles, joint.state, wrench, trend, 0.0, settings.dt, joint)
    first, parameter = joint.total.shape[0], first_parameter(covariance, settings)
    wrench_column = joint.total.shape[1] - N_NOISE
    set_total(joint.total, wrench_column, settings.disturbance_decay, parameter, recursion.total)
    _move_by_nuisances(jaw, muscles, (before, after, wrench, friction), settings, scratch)
    predict_covariance(covariance, noise_variance, recursion)
    for k in range(settings.disturbance_variance.shape[0]):
        covariance[first + k, first + k] += settings.disturbance_variance[k]


@njit
def read_bound(jaw: Jaw, motion, covariance, used, settings: FilterSettings, scratch: BoundScratch):
    """Take the readings of the end of a tick, of the true ``motion``, into the covariance."""
    joint, recursion = scratch.joint, scratch.recursion
    measure(jaw, motion, joint.rows, joint.expected)
    recursion.rows[:, :] = 0.0
    for i in range(joint.rows.shape[0]):
        for j in range(joint.rows.shape[1]):
            recursion.rows[i, j] = joint.rows[i, j]
    _read_by_nuisances(jaw, motion, used, settings, scratch)
    take_rows(covariance, settings.measurement_variance, used, recursion)


def _none_unknown(scratch):
    return not scratch.typeof("wrench").shape[1]


@where(_none_unknown, otherwise=f"{_NUISANCES}.move_by_nuisances")
def _move_by_nuisances(jaw: Jaw, muscles, tick, settings: FilterSettings, scratch: BoundScratch):
    """The effect of one sd of each nuisance on the motion at the tick's end, into its columns of the derivative."""


@where(_none_unknown, otherwise=f"{_NUISANCES}.read_by_nuisances")
def _read_by_nuisances(jaw: Jaw, motion, used, settings: FilterSettings, scratch: BoundScratch):
    """The effect of one sd of each nuisance on the readings, into its columns of their derivative."""
