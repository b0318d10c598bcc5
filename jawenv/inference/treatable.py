"""The patients whom the device can treat, for whom a simulation is defined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.anatomy import Patient
from jawenv.base.errors import InputError
from jawenv.envs.simulation import Simulation
from jawenv.inference.settings import DEFAULT_ENV, Mask, configuration_of, log_parameters, patient_of


def treatable(theta: ArrayLike, *, env_id: str = DEFAULT_ENV, env_kwargs: Mapping[str, Any] | None = None) -> Mask:
    """Mask of the patients whom the device can treat: whom ``reset`` of an environment takes.

    The relaxed jaw has to rest less than 35 mm open and 5 mm aside, with a painless range of 5 mm or more; F_o is at
    most 200 N and b at most 60 (``jawenv.Patient``). Anatomy and comfort decide; device and noise do not matter. The
    head is upright, and the jaw is the one that the filter believes in.

    Args:
        theta: (n, p) natural-log parameters, log F_o (N) and log b of each muscle in the order of
            ``env.unwrapped.parameter_names``.
        env_id: an environment of jawenv, for its model of the jaw.
        env_kwargs: its arguments, as ``anatomy`` and ``comfort``, but for ``control`` and ``episode_s``.

    Returns:
        (n,) bool.

    Raises:
        InputError: another id, another shape, parameters that are not finite, or an argument that is not allowed.
    """
    configuration = configuration_of(env_id, env_kwargs, {"control": "force", "episode_s": 0.05})
    simulation = Simulation(1, configuration)
    rows = log_parameters(theta, len(simulation.parameter_names))
    patients = (patient_of(row, simulation.cohort.muscles.names) for row in rows)
    key = np.zeros((1, 2), dtype=np.uint64)
    return np.array(
        [patient is not None and begins(simulation, 0, [patient], key) for patient in patients], dtype=np.bool_
    )


def begins(simulation: Simulation, index: int, patients: Sequence[Patient | None], keys: NDArray[np.uint64]) -> bool:
    """Begin the episode of one world; False, and all as before, where the device cannot treat its patient.

    Args:
        simulation: of n worlds.
        index: of the world.
        patients: n, with the muscles of the model; only that of this world is looked at.
        keys: (n, 2) of the episodes' random numbers.
    """
    chosen = np.zeros(len(keys), dtype=np.bool_)
    chosen[index] = True
    try:
        simulation.reset(chosen, patients, keys)
    except InputError:
        return False
    return True
