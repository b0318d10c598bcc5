"""skrl: the recipe of docs/environment.md, and steps that are the environment's own."""

import gymnasium as gym
import numpy as np
import pytest
from foreign.library import library, recipe

import jawenv  # noqa: F401 - registers the environments

pytestmark = [*library("skrl"), pytest.mark.filterwarnings("ignore::DeprecationWarning")]
torch = pytest.importorskip("torch")
pytest.importorskip("skrl")


def test_recipe():
    """PPO on `wrap_env` of the native vector form"""
    made = recipe("skrl")
    weights = torch.cat([weight.flatten() for weight in made["models"]["policy"].parameters()])
    assert torch.isfinite(weights).all() and made["env"].num_envs == 32


def test_steps():
    """`wrap_env` of the native vector form: the same steps, through ends of episodes"""
    from skrl.envs.wrappers.torch import wrap_env

    arguments = {"num_envs": 3, "episode_s": 0.6, "autoreset_mode": "same_step"}
    env, plain = wrap_env(gym.make_vec("jawenv/Jaw-v3", **arguments)), gym.make_vec("jawenv/Jaw-v3", **arguments)
    env._seed = 3
    np.testing.assert_array_equal(env.reset()[0], plain.reset(seed=3)[0])
    for action in np.random.default_rng(0).uniform(-1, 1, (7, 3, 4)).astype(np.float32):
        seen = env.step(torch.as_tensor(action))[:4]
        for one, other in zip(seen, plain.step(action)[:4], strict=True):
            np.testing.assert_allclose(one.numpy().reshape(np.shape(other)), other, rtol=1e-6)
