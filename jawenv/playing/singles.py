"""Single environments side by side, for ids that are registered without a vector form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from jawenv.errors import InputError, shown

if TYPE_CHECKING:
    from jawenv.anatomy import Prior
    from jawenv.envs.configuration import Configuration
    from jawenv.laboratory.recordings.record import Record

__all__ = ["SingleWorlds"]

Batch = tuple[npt.NDArray[np.float32], dict[str, Any]]


class SingleWorlds:
    """N single environments in the form that ``jawenv.play`` has of the native vector form.

    A world that has ended stands still, as with ``autoreset_mode="disabled"``. Infos keep the keys that are numbers,
    booleans or arrays.

    Args:
        env_id: id of an environment that is a ``JawEnv``, wrapped or not.
        number: N.
        env_kwargs: arguments of each.

    Raises:
        InputError: another environment, or what it refuses.
    """

    def __init__(self, env_id: str, number: int, env_kwargs: Mapping[str, Any]) -> None:
        import gymnasium as gym

        from jawenv.envs.jaw import JawEnv

        self.num_envs = number
        self._id = env_id
        self._envs = [gym.make(env_id, **env_kwargs) for _ in range(number)]
        if not isinstance(self._envs[0].unwrapped, JawEnv):
            raise InputError(f"env_id is {shown(env_id)}; allowed: an environment of jawenv, or a subclass of one")
        self._first = self._envs[0].unwrapped
        self._running = np.zeros(number, dtype=np.bool_)
        self._seen: list[Any] = [None] * number
        self._flags = np.zeros((2, number), dtype=np.bool_)

    @property
    def unwrapped(self) -> SingleWorlds:
        """Itself."""
        return self

    @property
    def configuration(self) -> Configuration:
        """The arguments of each world."""
        return self._first.configuration

    @property
    def prior(self) -> Prior:
        """The filter's prior over the log-parameters."""
        return self._first.prior

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the belief."""
        return self._first.parameter_names

    @property
    def simulation(self) -> Any:
        """What planners copy; there is none.

        Raises:
            InputError: always.
        """
        raise InputError(f"{self._id} has no native vector form, which agents that plan need")

    def reset(self, *, seed: Sequence[int], options: dict[str, Any] | None = None) -> Batch:
        """Start an episode in every world: i has entry i of ``seed`` and of ``options["patients"]``."""
        patients = (options or {}).get("patients", [None] * self.num_envs)
        for i, env in enumerate(self._envs):
            self._seen[i] = env.reset(seed=seed[i], options={"patient": patients[i]})
        self._running[:], self._flags[:] = True, False
        return self._together()

    def step(
        self, actions: npt.NDArray[np.float32]
    ) -> tuple[
        npt.NDArray[np.float32], npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]
    ]:
        """One control period of every world that goes on; ``actions`` (N, 4)."""
        rewards = np.zeros(self.num_envs)
        for i in np.flatnonzero(self._running).tolist():
            observation, rewards[i], *self._flags[:, i], info = self._envs[i].step(actions[i])
            self._seen[i] = observation, info
        self._running &= ~self._flags.any(axis=0)
        observations, infos = self._together()
        return observations, rewards, self._flags[0].copy(), self._flags[1].copy(), infos

    def _together(self) -> Batch:
        """Observations and infos of all worlds."""
        infos = [info for _, info in self._seen]
        keys = [key for key, value in infos[0].items() if isinstance(value, bool | int | float | np.ndarray)]
        together = {key: np.array([info[key] for info in infos]) for key in keys if all(key in info for info in infos)}
        return np.stack([observation for observation, _ in self._seen]), together

    def record(self, index: int) -> Record:
        """What the device of world ``index`` has measured."""
        from jawenv.laboratory.recordings.of_simulation import record_of

        unwrapped: Any = self._envs[index].unwrapped
        return record_of(unwrapped.simulation, 0)

    def close(self) -> None:
        """Close all."""
        for env in self._envs:
            env.close()
