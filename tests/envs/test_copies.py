"""A copy made in mid-episode is the same world: it goes on bit for bit, and its original does not notice."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest

from jawenv.envs.registration import ENVIRONMENTS

WAYS = {"deepcopy": copy.deepcopy, "pickle": lambda env: pickle.loads(pickle.dumps(env))}


def actions(number, steps, seed=0):
    """Coarse ones, which take the jaw to its stops."""
    return np.random.default_rng(seed).uniform(-1, 1, (steps, number, 4)).astype(np.float32)


def assert_same(one, other):
    """Two returns of ``step`` or ``reset``, infos included."""
    for mine, theirs in zip(one, other, strict=True):
        if not isinstance(mine, dict):
            np.testing.assert_array_equal(mine, theirs)
            continue
        assert list(mine) == list(theirs)
        for key in mine:
            np.testing.assert_array_equal(mine[key], theirs[key], err_msg=key)


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_a_copy_goes_on_like_its_original(env_id):
    env, untouched = gym.make(env_id), gym.make(env_id)
    for each in (env, untouched):
        each.reset(seed=3)
    for (action,) in actions(1, 15):
        assert_same(env.step(action), untouched.step(action))
    copies = [way(env) for way in WAYS.values()]
    for (action,) in actions(1, 15, seed=1):
        expected = untouched.step(action)
        for each in (env, *copies):
            assert_same(each.step(action), expected)
    expected = untouched.reset()
    for each in (env, *copies):
        assert_same(each.reset(), expected)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("env_id", ["jawenv/Jaw-v3", "jawenv/JawSagittal-v3"])
def test_a_copy_of_the_vector_form_goes_on_like_its_original(env_id, way):
    """Through the end of an episode."""
    env = gym.make_vec(env_id, num_envs=2, episode_s=1.0)
    env.reset(seed=3)
    for action in actions(2, 7):
        env.step(action)
    other = WAYS[way](env)
    for action in actions(2, 8, seed=1):
        assert_same(env.step(action), other.step(action))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("mode", ["rgb_array", "human"])
def test_a_copy_of_a_shown_environment_draws_its_own_pictures(mode, way, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gym.make("jawenv/Jaw-v3", render_mode=mode)
    env.reset(seed=3)
    env.step(np.ones(4, dtype=np.float32))
    picture = env.render()
    other = WAYS[way](env)
    renderer, copied = env.unwrapped._renderer, other.unwrapped._renderer
    assert copied._window is None and copied._frame is None
    assert copied._trace == renderer._trace and copied._trace is not renderer._trace
    np.testing.assert_array_equal(other.render(), picture)
    if mode == "human":
        assert copied._window is not None and renderer._window is not None
    other.close()
    env.close()
