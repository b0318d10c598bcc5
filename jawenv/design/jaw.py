"""An environment of jawenv as a design environment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import ArrayLike

from jawenv.base.errors import InputError
from jawenv.envs.jaw import JawEnv
from jawenv.inference.likelihood import log_likelihood
from jawenv.inference.patient_law import PatientLaw
from jawenv.inference.settings import Array
from jawenv.inference.simulations import simulate

_DRAWS = 1000
"""Patients by which the share of the treatable is known."""
_NOT_OF_SIMULATE = ("episode_s", "record", "render_mode")


class JawDesign(gym.Wrapper[Any, Any, Any, Any]):
    """Adds the prior, the simulator and the likelihood to an environment of jawenv.

    Args:
        env: made by ``gymnasium.make``, with patients of a named cohort.

    Raises:
        InputError: another environment.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        inner = env.unwrapped
        if not isinstance(inner, JawEnv) or env.spec is None:
            raise InputError("env is not of jawenv; allowed: one that gymnasium.make('jawenv/...') has made")
        self._env_id = env.spec.id
        self._arguments = {name: value for name, value in env.spec.kwargs.items() if name not in _NOT_OF_SIMULATE}
        self.parameter_names = inner.parameter_names
        self.prior = PatientLaw.of(inner.configuration.cohort, env_id=self._env_id, draws=_DRAWS)

    def simulate(self, theta: ArrayLike, actions: ArrayLike, seed: int) -> Mapping[str, Any]:
        """See ``DesignEnv``.

        Raises:
            InputError: parameters of a patient whom the device cannot treat, or another shape.
        """
        made = simulate(np.asarray(theta)[None], actions, seed, env_id=self._env_id, env_kwargs=self._arguments)
        record = made.records[0]
        if record is None:
            raise InputError("theta is of a patient whom the device cannot treat; allowed: one that prior.sample draws")
        return {"measured": record.measured, "samples": record.samples, "record": record}

    def log_likelihood(self, readings: Mapping[str, Any], theta: ArrayLike) -> Array | None:
        """See ``DesignEnv``: None where anatomy or device are known within errors only."""
        record = readings["record"]
        return log_likelihood(record, theta) if record.exact else None
