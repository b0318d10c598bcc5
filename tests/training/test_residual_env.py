"""Worlds in which an action corrects a maneuver."""

import numpy as np
import pytest

from agents.residual import N_FEATURES, BaseTargets, ResidualPolicy
from jawenv.errors import InputError
from jawenv.playing.maneuvers import Maneuver
from tests.training.counting_worlds import Counting
from training.worlds.residual_env import ResidualVecEnv

BASE = BaseTargets(Maneuver.named("opening_with_swings"), scale=0.5)
LENGTHS = (3, 5)


def steps(t: np.ndarray) -> np.ndarray:
    return np.repeat(t[:, None], 2, axis=1).astype(np.float32)


def counting(shape: tuple[int, ...] = (2,)) -> Counting:
    return Counting(LENGTHS, steps, shape)


def test_observation_space_holds_what_is_seen() -> None:
    worlds = ResidualVecEnv(counting(), BASE)
    assert worlds.observation_space.shape == (2 + N_FEATURES,)
    assert worlds.observation_space.contains(worlds.reset()[0])
    with pytest.raises(InputError, match="a residual needs a flat Box"):
        ResidualVecEnv(counting((2, 2)), BASE)


def test_features_follow_each_world_over_the_ends_of_its_episodes() -> None:
    worlds = ResidualVecEnv(counting(), BASE)
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

    inner = counting()
    worlds = ResidualVecEnv(inner, BASE)
    agent = ResidualPolicy(Drawn(), BASE, path=None, observation_size=2)  # type: ignore[arg-type]
    seen, starts = worlds.reset(), np.ones(2, bool)
    for t in range(12):
        action, _ = agent.predict(seen[:, :2], episode_start=starts)
        seen, _, starts, _ = worlds.step(drawn[t])
        np.testing.assert_array_equal(inner.actions[-1], action)
