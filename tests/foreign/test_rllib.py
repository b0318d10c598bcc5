"""RLlib: the recipe of docs/environment.md, in two processes of its own."""

import numpy as np
import pytest
from foreign.library import library, recipe

# Ray's own: what it imports or calls is out of date in other packages, and files that its processes keep open.
pytestmark = [*library("ray"), pytest.mark.filterwarnings("ignore")]
ray = pytest.importorskip("ray")
pytest.importorskip("ray.rllib", exc_type=ImportError)


def test_recipe():
    """PPO with two runners on the native vector form (`gym_env_vectorize_mode`)"""
    try:
        algorithm = recipe("ray.rllib")["algorithm"]
    finally:
        ray.shutdown()
    assert algorithm.config.gym_env_vectorize_mode == "vector_entry_point"
    assert np.isfinite(algorithm.iteration) and algorithm.iteration == 1


def test_its_runner_steps_the_native_form():
    """A runner steps the native vector form itself, and its steps are the environment's own"""
    import gymnasium as gym
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.rllib.env.single_agent_env_runner import SingleAgentEnvRunner

    from jawenv.envs.vector import JawVectorEnv

    config = PPOConfig().environment("jawenv:jawenv/Jaw-v3", env_config={"episode_s": 0.6})
    config = config.env_runners(num_envs_per_env_runner=2, gym_env_vectorize_mode="vector_entry_point")
    runner = SingleAgentEnvRunner(config=config.debugging(seed=3))
    assert isinstance(runner.env.unwrapped, JawVectorEnv)
    episodes = runner.sample(num_episodes=2, random_actions=True)
    runner.stop()
    plain = gym.make_vec("jawenv/Jaw-v3", 2, episode_s=0.6)
    plain.reset(seed=3)
    lengths = [len(episode) for episode in episodes]
    assert lengths == [3, 3] and all(episode.is_done for episode in episodes)
    for k in range(3):
        rewards = plain.step(np.stack([episode.get_actions(k) for episode in episodes]))[1]
        np.testing.assert_allclose([episode.get_rewards(k) for episode in episodes], rewards, rtol=1e-6)
