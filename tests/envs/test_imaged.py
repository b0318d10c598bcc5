"""The environment of a jaw that is known within sds, with a disturbance that lasts."""

import gymnasium as gym
import numpy as np
from gymnasium.utils.env_checker import check_env

import jawenv
from jawenv.device.device import device_of

ENV_ID = "jawenv/JawImaged-v3"


def test_it_is_an_environment_like_the_others():
    env = gym.make(ENV_ID, episode_s=2.0)
    check_env(env.unwrapped, skip_render_check=True)
    configuration = env.unwrapped.simulation.configuration
    assert configuration.build_knowledge() == jawenv.anatomy.knowledge.IMAGED
    assert device_of(configuration.device) == jawenv.Device(unmodelled_time_s=0.5)


def test_a_world_of_the_vector_form_is_the_single_one():
    one, many = gym.make(ENV_ID, episode_s=2.0), gym.make_vec(ENV_ID, 3, episode_s=2.0)
    first, _ = one.reset(seed=5)
    all_first, _ = many.reset(seed=[4, 5, 6])
    np.testing.assert_array_equal(first, all_first[1])
    for action in np.random.default_rng(0).uniform(-1, 1, (5, 3, 4)).astype(np.float32):
        observation, reward, *_ = one.step(action[1])
        observations, rewards, *_ = many.step(action)
        np.testing.assert_array_equal(observation, observations[1])
        assert reward == rewards[1]
    one.close()
    many.close()
