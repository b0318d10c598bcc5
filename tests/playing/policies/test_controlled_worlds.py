"""Worlds in which an action is a decision: a correction of a maneuver, or a target that a law follows."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv

from jawenv.base.errors import InputError
from jawenv.envs.observation import OBSERVATION_LAYOUT, Parts
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.policies.controller import ControlledAgent, ControlledWorlds
from jawenv.playing.policies.following import TargetsLaw
from jawenv.playing.policies.residual import N_FEATURES, BaseTargets, ResidualPolicy

BASE = BaseTargets(Maneuver.named("opening_with_swings"), scale=0.5)
TARGET = OBSERVATION_LAYOUT["motor_target"]


class Counting(VectorEnv[Any, Any, Any]):
    """Two worlds whose episodes have given lengths; each step is rewarded by 1 and costs its number; keeps actions.

    The first value of an observation counts the steps since the episode began, the comfort margins are 1.
    """

    def __init__(self, lengths: tuple[int, int], mode: AutoresetMode = AutoresetMode.SAME_STEP, axes: int = 1) -> None:
        self.num_envs, self.metadata = 2, {"autoreset_mode": mode}
        self.single_observation_space = spaces.Box(-2.0, 9.0, (Parts().size,) * axes, np.float32)
        self.single_action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)
        self._lengths = np.array(lengths)
        self.actions: list[np.ndarray] = []

    def _seen(self) -> np.ndarray:
        rows = np.zeros((2, Parts().size), np.float32)
        rows[:, OBSERVATION_LAYOUT["comfort_margin"]], rows[:, 0] = 1.0, self.t
        return rows

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        self.t = np.zeros(2, int)
        return self._seen(), {}

    def step(self, actions: np.ndarray) -> Any:
        self.actions.append(actions)
        self.t = self.t + 1
        done, last, cost = self.t >= self._lengths, self._seen(), self.t.astype(float)
        info: dict[str, Any] = {"cost": cost}
        if done.any():
            self.t = np.where(done, 0, self.t)
            info = {
                "cost": np.where(done, 0.0, cost),
                "final_info": {"cost": cost, "length": cost},
                "_final_info": done,
            }
            info |= {"final_obs": np.array([*last, None], dtype=object)[:2], "_final_obs": done}
        return self._seen(), np.ones(2), np.zeros(2, bool), done, info


@pytest.mark.parametrize("worlds", [Counting((3, 5), axes=2), Counting((3, 5), AutoresetMode.NEXT_STEP)])
def test_other_worlds_are_refused(worlds: Counting) -> None:
    with pytest.raises(InputError):
        ControlledWorlds(worlds, BASE)


def test_features_follow_each_world_over_the_ends_of_its_episodes() -> None:
    worlds = ControlledWorlds(Counting((3, 5)), BASE)
    assert worlds.single_observation_space.shape == (Parts().size + N_FEATURES,)
    seen, _ = worlds.reset()
    assert worlds.observation_space.contains(seen)
    ends = 0
    for _ in range(12):
        np.testing.assert_array_equal(seen[:, Parts().size :], BASE.features(seen[:, 0].astype(int)))
        seen, _, _, done, info = worlds.step(np.zeros((2, 4), np.float32))
        for i in np.flatnonzero(done):
            last = info["final_obs"][i]
            assert last[0] == (3, 5)[i] == info["final_info"]["cost"][i] and seen[i, 0] == 0 == info["cost"][i]
            np.testing.assert_array_equal(last[Parts().size :], BASE.features(np.array([(3, 5)[i]]))[0])
            ends += 1
    assert ends == 4 + 2


def test_an_episode_that_ends_between_two_decisions() -> None:
    inner = Counting((6, 8))
    worlds = ControlledWorlds(inner, TargetsLaw("force"))
    worlds.reset()
    goals = np.tile(np.array([-0.5, 0.5, 0.0, 0.0], np.float32), (2, 1))
    seen, reward, _, done, info = worlds.step(goals)
    assert len(inner.actions) == 4 and not done.any() and "final_obs" not in info
    np.testing.assert_array_equal([reward, info["cost"]], [[4.0, 4.0], [2.5, 2.5]])
    np.testing.assert_allclose(seen[:, TARGET], [[0.18, 0.5, 0.0, 0.0]] * 2, atol=1e-6)
    seen, reward, _, done, info = worlds.step(goals)
    assert done.tolist() == [True, True] and reward.tolist() == [2.0, 4.0]  # what follows is the next episode's
    assert info["final_info"]["length"].tolist() == [6, 8] and info["final_info"]["cost"].tolist() == [5.5, 6.5]
    assert info["_final_obs"].all() and all(last[TARGET][0] > 0.1 for last in info["final_obs"])
    np.testing.assert_array_equal(seen[:, TARGET], 0.0)  # both keep still
    assert inner.t.tolist() == [2, 0] and info["cost"].tolist() == [2.0, 0.0]


class Drawn:
    """Answers with random corrections, the same ones each time."""

    name = "drawn"

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        self.random = np.random.default_rng(0)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):  # noqa: ANN001, ANN201
        return self.random.uniform(-1, 1, (len(observation), 4)).astype(np.float32), None


def corrector() -> ResidualPolicy:
    return ResidualPolicy(Drawn(), BASE, path=None, parts=Parts())  # type: ignore[arg-type]


def test_worlds_and_agent_do_the_same() -> None:
    def jaws() -> Any:
        kwargs = {"autoreset_mode": "same_step", "control": "force", "episode_s": 2.0}
        return gym.make_vec("jawenv/Jaw-v3", 2, vectorization_mode="vector_entry_point", **kwargs)

    law, policy = TargetsLaw("force"), Drawn()
    worlds = ControlledWorlds(ControlledWorlds(jaws(), law), BASE)
    seen, _ = worlds.reset(seed=7)
    policy.reset(2)
    rewards, costs = np.zeros(2), np.zeros(2)
    for _ in range(10):
        seen, reward, _, done, info = worlds.step(policy.predict(seen)[0])
        rewards += reward
        costs += info["final_info"]["cost"] if done.all() else info["cost"]
    assert done.all()

    env, agent = jaws(), ControlledAgent(corrector(), law)
    seen, _ = env.reset(seed=7)
    agent.reset(2)
    total, discomfort = np.zeros(2), np.zeros(2)
    for _ in range(40):
        seen, reward, *_, alone = env.step(agent.predict(seen)[0])
        total += reward
        discomfort += alone["final_info"]["cost"] if "final_info" in alone else alone["cost"]
    np.testing.assert_allclose(rewards, total, rtol=1e-12)
    np.testing.assert_allclose(4.0 * costs, discomfort, rtol=1e-12)
    for ended, last in zip(info["final_obs"], alone["final_obs"], strict=True):
        np.testing.assert_array_equal(ended[: TARGET.start], last[: TARGET.start])
    np.testing.assert_array_equal(info["final_info"]["belief_sd"], alone["final_info"]["belief_sd"])
