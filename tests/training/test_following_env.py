"""Worlds in which an action is a target that the law follows for several control steps."""

import gymnasium as gym
import numpy as np

from agents.following import Following, TargetsLaw
from agents.residual import BaseTargets, ResidualPolicy
from jawenv.envs.observation import OBSERVATION_LAYOUT, OBSERVATION_SIZE
from jawenv.playing.maneuvers import Maneuver
from tests.training.counting_worlds import Counting
from training.run.config import EnvConfig
from training.run.train import make_worlds, wrapped
from training.worlds.following_env import FollowingVecEnv
from training.worlds.residual_env import ResidualVecEnv

BASE = BaseTargets(Maneuver.named("opening_with_swings"), scale=0.5)
TARGET = OBSERVATION_LAYOUT["motor_target"]


def at_rest(t: np.ndarray) -> np.ndarray:
    rows = np.zeros((2, OBSERVATION_SIZE), np.float32)
    rows[:, OBSERVATION_LAYOUT["comfort_margin"]] = 1.0
    return rows


def test_an_episode_that_ends_between_two_decisions() -> None:
    inner = Counting((6, 8), at_rest, (OBSERVATION_SIZE,))
    worlds = FollowingVecEnv(inner, TargetsLaw("force"))
    worlds.reset()
    goals = np.tile(np.array([-0.5, 0.5, 0.0, 0.0], np.float32), (2, 1))
    observation, reward, done, infos = worlds.step(goals)
    np.testing.assert_array_equal(reward, 4.0)
    assert len(inner.actions) == 4 and not done.any() and infos == [{}, {}]
    np.testing.assert_allclose(np.asarray(observation)[:, TARGET], [[0.18, 0.5, 0.0, 0.0]] * 2, atol=1e-6)
    observation, reward, done, infos = worlds.step(goals)
    assert done.tolist() == [True, True] and reward.tolist() == [2.0, 4.0]  # what follows is the next episode's
    assert [info["episode"]["l"] for info in infos] == [6, 8]
    assert all(info["terminal_observation"][TARGET][0] > 0.1 for info in infos)
    np.testing.assert_array_equal(np.asarray(observation)[:, TARGET], 0.0)  # both keep still
    assert inner.t.tolist() == [2, 0]


class Drawn:
    """Answers with random corrections, the same ones each time."""

    name = "drawn"

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        self.random = np.random.default_rng(0)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):  # noqa: ANN001, ANN201
        return self.random.uniform(-1, 1, (len(observation), 4)).astype(np.float32), None


def test_training_and_agent_do_the_same() -> None:
    config = EnvConfig(kwargs={"control": "force", "episode_s": 2.0})
    law = TargetsLaw("force")
    trained = wrapped(make_worlds(config, 2), BASE, law)
    assert isinstance(trained, ResidualVecEnv)
    trained.seed(7)
    trained.reset()
    policy = Drawn()
    policy.reset(2)
    rewards = []
    for _ in range(10):
        _, reward, done, infos = trained.step(policy.predict(np.zeros((2, 1)))[0])
        rewards.append(reward)
    assert done.all()

    env = gym.make_vec(
        config.id, 2, vectorization_mode="vector_entry_point", autoreset_mode="same_step", **config.kwargs
    )
    seen, _ = env.reset(seed=7)
    agent = Following(ResidualPolicy(Drawn(), BASE, path=None, observation_size=OBSERVATION_SIZE), law)  # type: ignore[arg-type]
    agent.reset(2)
    total = np.zeros(2)
    for _ in range(40):
        action, _ = agent.predict(seen)
        seen, reward, *_, info = env.step(action)
        total += reward
    np.testing.assert_allclose(np.sum(rewards, axis=0), total, rtol=1e-4)
    ended = [info_["terminal_observation"][: TARGET.start] for info_ in infos]
    np.testing.assert_allclose(ended, np.array(list(info["final_obs"]))[:, : TARGET.start], atol=1e-5)
