"""``Point-v0``: a small native vector environment with continuous actions; steer a point to the origin.

It speaks jawenv's dialect (cost, information, violation in ``info``) and resets in an episode's last step.
"""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from jawenv.base.errors import InputError

EPISODE_STEPS = 20
LIMIT = 1.5
DT_S = 0.6  # EPISODE_STEPS take 12 s

TINY_CONFIG = """
steps: 1024
n_envs: 8
env: {id: "point_env:Point-v0"}
arguments: {n_steps: 32, batch_size: 64, learning_rate: {initial: 0.003}}
evaluation: {every_steps: 512, patients: 4}
checkpoints: {every_steps: 256, keep: 2}
"""
"""Settings of a run of a second or two."""


class PointVectorEnv(VectorEnv):
    """State x (N, 2) moves by 0.1 action; reward is the decrease of |x|; |x| > LIMIT ends an episode."""

    def __init__(self, num_envs: int = 1, autoreset_mode: str = "next_step", start: float = 1.0) -> None:
        if start <= 0.0:
            raise InputError(f"start is {start}: must be > 0")
        self.metadata = {"autoreset_mode": AutoresetMode[autoreset_mode.upper()]}
        self.num_envs = num_envs
        self.start = start
        self.single_observation_space = spaces.Box(-2.0, 2.0, (3,), np.float32)
        self.single_action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        if seed is not None:
            self.generators = [np.random.default_rng(seed + i) for i in range(self.num_envs)]
        self.x = np.array([self._draw(i) for i in range(self.num_envs)])
        self.t = np.zeros(self.num_envs, dtype=int)
        self.gained = np.zeros(self.num_envs)
        return self._observe(), self._info()

    def step(self, actions: np.ndarray) -> Any:
        before = np.linalg.norm(self.x, axis=1)
        self.x = self.x + 0.1 * actions
        self.t += 1
        reward = before - np.linalg.norm(self.x, axis=1)
        self.gained += reward
        terminated = np.linalg.norm(self.x, axis=1) > LIMIT
        truncated = self.t >= EPISODE_STEPS
        info = self._info()
        done = terminated | truncated
        if done.any():
            info = {"final_obs": self._observe(), "_final_obs": done, "final_info": info, "_final_info": done}
            for i in np.flatnonzero(done).tolist():
                self.x[i] = self._draw(i)
            self.t[done] = 0
            self.gained[done] = 0.0
            info |= self._info()
        return self._observe(), reward, terminated, truncated, info

    def _draw(self, i: int) -> np.ndarray:
        angle = self.generators[i].uniform(0.0, 2.0 * np.pi)
        return self.start * np.array([np.cos(angle), np.sin(angle)])

    def _observe(self) -> np.ndarray:
        return np.column_stack([self.x, self.t / EPISODE_STEPS]).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        distance = np.linalg.norm(self.x, axis=1)
        return {
            "time": DT_S * self.t,
            "belief_sd": np.column_stack([0.1 / (1.0 + self.t), 0.5 / (1.0 + self.t)]),
            "cost": np.maximum(0.0, distance - 1.0),
            "information_claimed": self.gained.copy(),
            "information_true": 0.5 * self.gained,
            "violation": distance > LIMIT,
        }


gym.register("Point-v0", vector_entry_point="point_env:PointVectorEnv")
