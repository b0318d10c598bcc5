"""Information and observation by the beliefs of the user's estimators; compiled at its first use."""

from __future__ import annotations

from jawenv.envs.world.information import refresh_information
from jawenv.envs.world.observation import observe_world
from jawenv.envs.world.step_kernel import Shared
from jawenv.kernels.compiled import world_kernel


@world_kernel(position=2)
def show_beliefs(shared: Shared, models, worlds, active, observation, part):
    """Information and observation of every active world by the belief that its record holds now.

    Args:
        shared: See ``step_kernel.Shared``.
        models: Jaws as the filter believes them, one for each world.
        worlds: Worlds, dtype ``world_dtype``.
        active: (N,) bool.
        observation: (N, size) float32, filled where a world is active.
        part: First world, one past the last, and number of the thread (``compiled.WorldKernel``).
    """
    first, last, thread = part
    settings, scratch = shared.settings[0], shared.scratches[thread]
    for i in range(first, last):
        if active[i]:
            known = worlds[i].known
            refresh_information(worlds[i], scratch.matrix, scratch.right)
            observe_world(
                shared.devices[0], models[i], known, settings.control, settings.filter, scratch.seeing, observation[i]
            )
