"""Single environments side by side, for ids that are registered without a vector form."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from jawenv.base.errors import InputError, shown

if TYPE_CHECKING:
    from jawenv.recordings.record import Record

__all__ = ["SingleWorlds"]


class _World(gym.Wrapper[Any, Any, Any, Any]):
    """World ``index``: has its own patient of those in the options, and stands still after its end."""

    def __init__(self, env_id: str, index: int, env_kwargs: Mapping[str, Any]) -> None:
        from jawenv.envs.jaw import JawEnv

        super().__init__(gym.make(env_id, **env_kwargs))
        if not isinstance(self.unwrapped, JawEnv):
            raise InputError(f"env_id is {shown(env_id)}; allowed: an environment of jawenv, or a subclass of one")
        self._index, self._last = index, (np.empty(0), dict[str, Any]())
        self.ended = (False, False)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        patients = (options or {}).get("patients")
        self.ended = (False, False)
        return self.env.reset(seed=seed, options=None if patients is None else {"patient": patients[self._index]})

    def step(self, action: Any) -> Any:
        reward: Any = 0.0
        if not any(self.ended):
            observation, reward, terminated, truncated, info = self.env.step(action)
            self._last, self.ended = (observation, info), (terminated, truncated)
        return self._last[0], reward, False, False, self._last[1]


class SingleWorlds(SyncVectorEnv):
    """N single environments in the form that ``jawenv.play`` has of the native vector form.

    A world that has ended stands still; Gymnasium's own refuse to step one.

    Args:
        env_id: id of an environment that is a ``JawEnv``, wrapped or not.
        number: N.
        env_kwargs: arguments of each.
    """

    def __init__(self, env_id: str, number: int, env_kwargs: Mapping[str, Any]) -> None:
        worlds = [partial(_World, env_id, i, env_kwargs) for i in range(number)]
        super().__init__(worlds, autoreset_mode=AutoresetMode.DISABLED)
        first: Any = self.envs[0].unwrapped
        self.configuration, self.prior, self.parameter_names = first.configuration, first.prior, first.parameter_names
        self._id = env_id

    def step(self, actions: Any) -> Any:
        """One control period of every world that goes on; ``actions`` (N, 4)."""
        observations, rewards, _, _, infos = super().step(actions)
        terminated, truncated = np.array([cast(_World, world).ended for world in self.envs]).T
        return observations, rewards, terminated, truncated, infos

    @property
    def simulation(self) -> Any:
        """The simulation, which planners copy; there is none."""
        raise InputError(f"{self._id} has no native vector form, which agents that plan need")

    def record(self, index: int) -> Record:
        """The record of the device of world ``index``."""
        from jawenv.recordings.of_simulation import record_of

        world: Any = self.envs[index].unwrapped
        return record_of(world.simulation, 0)
