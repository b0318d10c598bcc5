"""The posterior Cramer-Rao bound along the true motion, of the ticks of the last control period.

It runs after ``advance``, over what that has kept of the truth, and only where the bound is asked for: it is compiled
at its first use.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from jawenv.envs.information import decompose_parameters
from jawenv.envs.plants import TICK
from jawenv.filter.joint_recursion import joint_scratch_dtype, predict_covariance, update_covariance
from jawenv.filter.joint_step import propagate
from jawenv.kernels.compiled import njit, njit_within, world_kernel
from jawenv.kernels.records import record_dtype


@cache
def bound_scratch_dtype(n_muscles: int, n_lines: int, n_states: int) -> np.dtype[np.void]:
    """Dtype of one thread's working memory."""
    return record_dtype(
        [
            ("joint", joint_scratch_dtype(n_muscles, n_lines, n_states)),
            ("matrix", "f8", (2 * n_muscles, 2 * n_muscles)),
        ]
    )


@njit
def prior_covariance(settings, covariance):
    """The joint prior over motion, log-parameters and gain, from the filter's ``settings``."""
    parameters = settings.prior_sd.shape[0]
    first = (
        covariance.shape[0] - parameters - 1
    )  # states of the motion: a disturbance with memory is none of the bound's
    covariance[:, :] = 0.0
    for i in range(first):
        covariance[i, i] = settings.start_sd[i] * settings.start_sd[i]
    for i in range(parameters):
        covariance[first + i, first + i] = settings.prior_sd[i] * settings.prior_sd[i]
    covariance[first + parameters, first + parameters] = settings.gain_variance


@njit_within
def follow_bound(model, world, settings, scratch, path):
    """The bound of one world after its last control period, or after its first reading."""
    truth, joint, tick = world.truth, scratch.joint, world.known.tick
    rows, begun, known = path.shape[0], tick == 0, settings.filter
    if begun:
        prior_covariance(known, truth.bound)
    for k in range(tick if begun else tick - settings.control.ticks_per_step + 1, tick + 1):
        row = path[k % rows]
        if not begun:
            joint.state[:] = path[(k - 1) % rows].state
            propagate(model, truth.muscles, joint.state, row.wrench, row.trend, 0.0, TICK, joint)
            predict_covariance(truth.bound, settings.noise_variance, joint)
        joint.state[:] = row.state
        update_covariance(model, joint.state, truth.bound, known.measurement_variance, known.used, joint)
    truth.log_det_bound = decompose_parameters(truth.bound, joint.state.shape[0], scratch.matrix)


@world_kernel(place=1)
def track_bound(models, worlds, active, all_settings, scratches, all_paths, part):
    """The bound of every active world after its last control period.

    Args:
        models: Jaws as the filter believes them, one for each world, dtype ``jaw_dtype``.
        worlds: Worlds, dtype ``world_dtype``; ``bound`` and ``log_det_bound`` of their truth are changed.
        active: (N,) bool, as ``advance`` was given.
        all_settings: One record of dtype ``settings_dtype``, in an array.
        scratches: Working memory, dtype ``bound_scratch_dtype``, one for each thread.
        all_paths: (N, ticks in a period + 1 or more) records of dtype ``true_tick_dtype``.
        part: First world, one past the last, and number of the thread (``compiled.WorldKernel``).
    """
    first, last, thread = part
    for i in range(first, last):
        if active[i]:
            follow_bound(models[i], worlds[i], all_settings[0], scratches[thread], all_paths[i])
