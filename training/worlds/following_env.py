"""Worlds of force or trajectory control in which an action is a target, for stable-baselines3."""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvObs, VecEnvStepReturn, VecEnvWrapper

from agents.following import TargetsLaw


class FollowingVecEnv(VecEnvWrapper):
    """One step is one decision: the law follows its targets for several control steps, as `agents.following.Following`.

    The reward is the sum over these steps. A world whose episode ends between two decisions is done, and keeps still in
    its next episode until the next decision.

    Args:
        worlds: N worlds in force or trajectory control.
        law: follows the targets.
    """

    def __init__(self, worlds: VecEnv, law: TargetsLaw) -> None:
        super().__init__(worlds)
        self._law = law
        self._begin()

    def _begin(self) -> None:
        self._trackers = self._law.begin(self.num_envs)
        self._rows = np.zeros((self.num_envs, 0), dtype=np.float32)

    def reset(self) -> VecEnvObs:
        """Start new episodes in all worlds. Returns observations (N, n_obs)."""
        self._begin()
        return self._seen(self.venv.reset())

    def step_async(self, actions: np.ndarray) -> None:
        """Set out for the targets of ``actions`` (N, 4)."""
        self._law.aim(self._trackers, actions)

    def step_wait(self) -> VecEnvStepReturn:
        """Follow them to the next decision. Returns observations (N, n_obs), rewards (N,), dones (N,) and N infos."""
        total, ended = np.zeros(self.num_envs, dtype=np.float32), np.zeros(self.num_envs, dtype=bool)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for _ in range(self._law.steps_per_decision):
            self.venv.step_async(self._law.actions(self._rows, self._trackers))
            observation, reward, done, told = self.venv.step_wait()
            total += np.where(ended, 0.0, reward)
            for i in np.flatnonzero(done & ~ended).tolist():
                last = self._law.seen(told[i]["terminal_observation"][None], self._trackers[i : i + 1])
                infos[i] = {**told[i], "terminal_observation": last[0]}
            self._trackers[done] = self._law.begin(int(done.sum()))
            ended |= done
            self._rows = np.asarray(observation, dtype=np.float32)
        return self._seen(observation), total, ended, infos

    def _seen(self, observation: VecEnvObs) -> np.ndarray:
        self._rows = np.asarray(observation, dtype=np.float32)
        return self._law.seen(self._rows, self._trackers)
