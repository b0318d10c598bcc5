"""The posterior Cramer-Rao bound along the true motion, of the ticks of the last control period.

It runs after ``advance``, over what that has kept of the truth, and only where the bound is asked for: it is compiled
at its first use.
"""

from __future__ import annotations

from jawenv.envs.world.information import decompose_parameters
from jawenv.envs.world.record import Settings, World
from jawenv.filter.bound.bound_recursion import BoundScratch, begin_bound, first_parameter, move_bound, read_bound
from jawenv.kernels.compiled import njit_within, world_kernel
from jawenv.mechanics.jaw import Jaw


@njit_within
def _follow_bound(model: Jaw, world: World, settings: Settings, scratch: BoundScratch, path):
    """The bound of one world after its last control period, or after its first reading."""
    truth, tick = world.truth, world.known.tick
    rows, begun, filter_settings = path.shape[0], tick == 0, settings.filter
    jaw = truth.jaw if filter_settings.nuisances.mass.shape[0] > 0 else model
    if begun:
        begin_bound(filter_settings, truth.bound)
    for k in range(tick if begun else tick - settings.control.ticks_per_step + 1, tick + 1):
        row = path[k % rows]
        if not begun:
            before = path[(k - 1) % rows].state
            true = (truth.muscles, before, row.state, row.wrench, row.trend, row.friction_share)
            move_bound(jaw, truth.bound, true, filter_settings, settings.noise_variance, scratch)
        read_bound(jaw, row.state, truth.bound, filter_settings.used, filter_settings, scratch)
    truth.log_det_bound = decompose_parameters(
        truth.bound, first_parameter(truth.bound, filter_settings), scratch.matrix
    )


@world_kernel(position=1)
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
            _follow_bound(models[i], worlds[i], all_settings[0], scratches[thread], all_paths[i])
