"""Two worlds for stable-baselines3 that do nothing but count their steps."""

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env.base_vec_env import VecEnv


class Counting(VecEnv):
    """Two worlds whose episodes have given lengths; each step is rewarded by 1; keeps the actions.

    Args:
        lengths: (2,) of the episodes, in steps.
        seen: observations (2, ...) for the steps (2,) since the episodes began.
        shape: of one observation.
    """

    def __init__(
        self, lengths: tuple[int, int], seen: Callable[[np.ndarray], np.ndarray], shape: tuple[int, ...]
    ) -> None:
        super().__init__(2, spaces.Box(-2.0, 9.0, shape, np.float32), spaces.Box(-1.0, 1.0, (4,), np.float32))
        self._lengths, self._seen = np.array(lengths), seen
        self.actions: list[np.ndarray] = []

    def reset(self) -> np.ndarray:
        self.t = np.zeros(2, int)
        return self._seen(self.t)

    def step_async(self, actions: np.ndarray) -> None:
        self.actions.append(actions)

    def step_wait(self) -> Any:
        self.t += 1
        done, infos = self.t >= self._lengths, [{}, {}]
        for i in np.flatnonzero(done):
            infos[i] = {"terminal_observation": self._seen(self.t)[i], "episode": {"l": int(self.t[i])}}
        self.t[done] = 0
        return self._seen(self.t), np.ones(2, np.float32), done, infos

    def close(self) -> None: ...

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [None] * 2

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None: ...

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        return []

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * 2
