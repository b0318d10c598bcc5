"""Worlds in which an action is a correction of a maneuver, for stable-baselines3."""

from __future__ import annotations

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvObs, VecEnvStepReturn, VecEnvWrapper

from agents.residual import N_FEATURES, BaseTargets
from jawenv.errors import InputError


class ResidualVecEnv(VecEnvWrapper):
    """Adds the maneuver's targets to observations and actions, as `agents.residual.ResidualPolicy` does.

    Args:
        worlds: N worlds whose actions are targets.
        base: the maneuver.

    Raises:
        InputError: the observation is not a flat Box.
    """

    def __init__(self, worlds: VecEnv, base: BaseTargets) -> None:
        inner = worlds.observation_space
        if not isinstance(inner, spaces.Box) or len(inner.shape) != 1:
            raise InputError(f"observation space is {inner}, but a residual needs a flat Box")
        low = np.concatenate([inner.low, np.full(N_FEATURES, -1.0)]).astype(np.float32)
        high = np.concatenate([inner.high, np.full(N_FEATURES, 1.0)]).astype(np.float32)
        super().__init__(worlds, observation_space=spaces.Box(low, high, dtype=np.float32))
        self.base = base
        self._step = np.zeros(self.num_envs, dtype=np.int64)

    def reset(self) -> VecEnvObs:
        """Start new episodes in all worlds. Returns observations (N, n_obs + 12)."""
        observation = self.venv.reset()
        self._step = np.zeros(self.num_envs, dtype=np.int64)
        return self._seen(np.asarray(observation))

    def step_async(self, actions: np.ndarray) -> None:
        """Hand on the maneuver's targets with the residual ``actions`` (N, 4) added."""
        self.venv.step_async(self.base.actions(self._step, actions))

    def step_wait(self) -> VecEnvStepReturn:
        """Step all worlds. Returns observations (N, n_obs + 12), rewards (N,), dones (N,) and N infos."""
        observation, reward, done, infos = self.venv.step_wait()
        after = self._step + 1
        if done.any():
            ended = self.base.features(after)
            for i in np.flatnonzero(done).tolist():
                infos[i]["terminal_observation"] = np.concatenate([infos[i]["terminal_observation"], ended[i]])
        self._step = np.where(done, 0, after)
        return self._seen(np.asarray(observation)), reward, done, infos

    def _seen(self, observation: np.ndarray) -> np.ndarray:
        return np.concatenate([observation, self.base.features(self._step)], axis=1)
