"""An episode that an autoreset began is begun again by its key, in either form."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.base.errors import InputError

SHORT = {"episode_s": 0.4, "knowledge": "exact"}


@pytest.mark.parametrize("mode", ["same_step", "next_step"])
def test_the_key_begins_the_episode_of_an_autoreset_again(mode):
    worlds = gym.make_vec("jawenv/Jaw-v3", num_envs=3, autoreset_mode=mode, **SHORT)
    _, info = worlds.reset(seed=5)
    before, actions = info["episode_key"], np.zeros((3, 4), np.float32)
    for _ in range(2 + (mode == "next_step")):
        observation, *_, info = worlds.step(actions)
    keys = info["episode_key"]
    assert keys.shape == (3, 2) and (keys != before).all()
    after = worlds.step(actions)

    again = gym.make_vec("jawenv/Jaw-v3", num_envs=3, **SHORT)
    np.testing.assert_array_equal(again.reset(seed=9, options={"episode_keys": keys})[0], observation)
    np.testing.assert_array_equal(again.step(actions)[0], after[0])
    one = gym.make("jawenv/Jaw-v3", **SHORT)
    first, told = one.reset(options={"episode_key": keys[1]})
    np.testing.assert_array_equal(first, observation[1])
    np.testing.assert_array_equal(told["truth"], info["truth"][1])
    np.testing.assert_array_equal(told["episode_key"], keys[1])


def test_a_refused_patient_keeps_the_key():
    one = gym.make("jawenv/Jaw-v3", **SHORT)
    key = one.reset(seed=1)[1]["episode_key"]
    blocked = jawenv.Patient(
        F_o_N=dict.fromkeys(jawenv.MUSCLE_NAMES, 200.0), b=dict.fromkeys(jawenv.MUSCLE_NAMES, 60.0)
    )
    with pytest.raises(InputError, match="no rest pose"):
        one.reset(options={"patient": blocked})
    np.testing.assert_array_equal(one.step(np.zeros(4, np.float32))[4]["episode_key"], key)


@pytest.mark.parametrize("key", [3, [1, 2, 3], [0.5, 1.0], [-1, 2], [2**63, 1], "ab"])
def test_what_is_no_key_is_refused(key):
    with pytest.raises(InputError, match="option episode_key is .*; allowed: info"):
        gym.make("jawenv/Jaw-v3", **SHORT).reset(options={"episode_key": key})
