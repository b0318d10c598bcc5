"""An environment of jawenv as a design environment."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv  # noqa: F401  registers its environments
from jawenv.base.errors import InputError
from jawenv.design import JawDesign


def test_readings_are_likelier_under_the_parameters_that_made_them():
    env = JawDesign(gym.make("jawenv/JawHinge-v3", control="force"))
    theta, actions = env.prior.sample(4, 0), np.full((10, 4), 0.1)
    first, again = (env.simulate(theta[0], actions, 0) for _ in range(2))
    np.testing.assert_array_equal(first["measured"], again["measured"])
    assert env.log_likelihood(first, theta).argmax() == 0 and np.isfinite(env.prior.log_density(theta)).all()
    env.close()


def test_one_that_draws_pictures_simulates_as_well():
    env = JawDesign(gym.make("jawenv/JawHinge-v3", control="force", render_mode="rgb_array"))
    readings = env.simulate(env.prior.sample(1, 0)[0], np.zeros((2, 4)), 0)
    assert readings["measured"].shape == (11, 12)
    env.close()


def test_another_environment_is_refused():
    with pytest.raises(InputError, match="not of jawenv"):
        JawDesign(gym.make("CartPole-v1"))
