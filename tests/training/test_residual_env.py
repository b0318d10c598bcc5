"""Worlds in which an action corrects a maneuver."""

from typing import Any

import numpy as np
import pytest
from gymnasium import spaces
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from agents.residual import N_FEATURES, BaseTargets, ResidualPolicy
from jawenv.errors import InputError
from jawenv.maneuvers import Maneuver
from training.residual_env import ResidualVecEnv

BASE = BaseTargets(Maneuver.named("opening_with_swings"), scale=0.5)
LENGTHS = np.array([3, 5])


class Counting(VecEnv):
    """Two worlds whose episodes take 3 and 5 steps; the observation (2) is the step; keeps the actions."""

    def __init__(self, shape: tuple[int, ...] = (2,)) -> None:
        super().__init__(2, spaces.Box(-2.0, 9.0, shape, np.float32), spaces.Box(-1.0, 1.0, (4,), np.float32))
        self.actions: list[np.ndarray] = []

    def reset(self) -> np.ndarray:
        self.t = np.zeros(2, int)
        return self._seen()

    def _seen(self) -> np.ndarray:
        return np.repeat(self.t[:, None], 2, axis=1).astype(np.float32)

    def step_async(self, actions: np.ndarray) -> None:
        self.actions.append(actions)

    def step_wait(self) -> Any:
        self.t += 1
        done, infos = self.t >= LENGTHS, [{}] * 2
        for i in np.flatnonzero(done):
            infos[i] = {"terminal_observation": self._seen()[i]}
        self.t[done] = 0
        return self._seen(), np.ones(2, np.float32), done, infos

    def close(self) -> None: ...

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [None] * 2

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None: ...

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        return []

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * 2


def test_observation_space_holds_what_is_seen() -> None:
    worlds = ResidualVecEnv(Counting(), BASE)
    assert worlds.observation_space.shape == (2 + N_FEATURES,)
    assert worlds.observation_space.contains(worlds.reset()[0])
    with pytest.raises(InputError, match="a residual needs a flat Box"):
        ResidualVecEnv(Counting((2, 2)), BASE)


def test_features_follow_each_world_over_the_ends_of_its_episodes() -> None:
    worlds = ResidualVecEnv(Counting(), BASE)
    seen = worlds.reset()
    ends = 0
    for _ in range(12):
        np.testing.assert_array_equal(seen[:, 2:], BASE.features(seen[:, 0].astype(int)))
        seen, _, done, infos = worlds.step(np.zeros((2, 4)))
        for i in np.flatnonzero(done):
            last = infos[i]["terminal_observation"]
            assert last[0] == LENGTHS[i] and seen[i, 0] == 0
            np.testing.assert_array_equal(last[2:], BASE.features(np.array([LENGTHS[i]]))[0])
            ends += 1
    assert ends == 4 + 2


def test_actions_are_those_of_the_agent() -> None:
    drawn = np.random.default_rng(0).uniform(-1, 1, (12, 2, 4))

    class Drawn:
        name = "drawn"
        step = -1

        def reset(self, num_envs: int, seed: int | None = None) -> None: ...

        def predict(self, observation, state=None, episode_start=None, deterministic=True):  # noqa: ANN001, ANN201
            self.step += 1
            return drawn[self.step], None

    inner = Counting()
    worlds = ResidualVecEnv(inner, BASE)
    agent = ResidualPolicy(Drawn(), BASE, path=None, observation_size=2)  # type: ignore[arg-type]
    seen, starts = worlds.reset(), np.ones(2, bool)
    for t in range(12):
        action, _ = agent.predict(seen[:, :2], episode_start=starts)
        seen, _, starts, _ = worlds.step(drawn[t])
        np.testing.assert_array_equal(inner.actions[-1], action)
