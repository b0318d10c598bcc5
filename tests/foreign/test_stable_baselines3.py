"""stable-baselines3: its checker, its vector environments, a short training and a saved model."""

import gymnasium as gym
import numpy as np
import pytest
from foreign.library import ids_and_controls, library

import jawenv  # noqa: F401 - registers the environments

stable_baselines3 = pytest.importorskip("stable_baselines3")
pytestmark = library("stable_baselines3")


@pytest.mark.parametrize(("env_id", "control"), ids_and_controls())
def test_check_env(env_id, control):
    """`check_env`: every id and control mode"""
    from stable_baselines3.common.env_checker import check_env

    check_env(gym.make(env_id, control=control, episode_s=1.0).unwrapped, warn=True)


@pytest.mark.parametrize("kind", ["DummyVecEnv", "SubprocVecEnv"])
def test_vector_environments(kind):
    """`make_vec_env` with worlds in one process and in several"""
    from stable_baselines3.common import vec_env
    from stable_baselines3.common.env_util import make_vec_env

    # The part before the colon is imported where the world is made, in whichever process.
    env = make_vec_env("jawenv:jawenv/Jaw-v3", 2, 3, env_kwargs={"episode_s": 0.6}, vec_env_cls=getattr(vec_env, kind))
    try:
        native = gym.make_vec("jawenv/Jaw-v3", 2, episode_s=0.6)
        np.testing.assert_array_equal(env.reset(), native.reset(seed=3)[0])
        for _ in range(3):
            observation, _, done, infos = env.step(np.zeros((2, 4), np.float32))
        last = native.step(np.zeros((2, 4), np.float32))
        assert done.all() and all(info["TimeLimit.truncated"] for info in infos)
        assert infos[0]["terminal_observation"].shape == last[0][0].shape == observation[0].shape
    finally:
        env.close()


@pytest.mark.parametrize("name", ["PPO", "SAC"])
def test_learning(name, tmp_path):
    """PPO and SAC learn some steps; the saved model decides as before"""
    arguments = {"PPO": {"n_steps": 32, "batch_size": 32}, "SAC": {"learning_starts": 16}}[name]
    env = gym.make("jawenv/Jaw-v3", episode_s=1.0)
    algorithm = getattr(stable_baselines3, name)
    model = algorithm("MlpPolicy", env, seed=0, device="cpu", policy_kwargs={"net_arch": [16]}, **arguments).learn(40)
    model.save(tmp_path / "model.zip")
    observation, _ = env.reset(seed=0)
    decisions = [one.predict(observation, deterministic=True)[0] for one in (model, algorithm.load(tmp_path / "model"))]
    np.testing.assert_array_equal(*decisions)
    assert env.action_space.contains(decisions[0])
