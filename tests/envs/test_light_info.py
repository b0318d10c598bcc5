"""A light info has fewer keys, with the values that the full one has."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.base.errors import InputError

KEYS = {"belief_mean", "belief_sd", "truth", "cost", "violation", "misfit", "time", "episode_key"}


@pytest.mark.parametrize("bound", [False, True])
def test_a_single_environment_gives_the_light_keys_with_the_same_values(bound):
    envs = [gym.make("jawenv/Jaw-v3", info=info, track_bound=bound).unwrapped for info in ("full", "light")]
    full, light = (env.reset(seed=3)[1] for env in envs)
    for _ in range(3):
        assert light.keys() == KEYS | ({"bound_sd", "information_bound"} if bound else set())
        for key, value in light.items():
            np.testing.assert_array_equal(value, full[key])
        action = np.full(4, 0.3, dtype=np.float32)
        (*one, full), (*other, light) = (env.step(action) for env in envs)
        np.testing.assert_array_equal(one[0], other[0])
        assert one[1:] == other[1:]


def test_the_vector_form_gives_the_light_keys_also_of_the_episode_that_ended():
    env = gym.make_vec("jawenv/Jaw-v3", num_envs=2, info="light", episode_s=0.4, autoreset_mode="same_step")
    _, info = env.reset(seed=3)
    assert {key for key in info if not key.startswith("_")} == KEYS
    for _ in range(2):
        *_, info = env.step(np.zeros((2, 4), dtype=np.float32))
    assert KEYS < {key for key in info["final_info"]}
    assert "nees" not in info["final_info"] and "nees" not in info


def test_episodes_of_many_patients_have_all_whatever_info_is_asked_for():
    kwargs = {"info": "light", "episode_s": 0.4}
    played = jawenv.play(jawenv.Player("hold_still"), patients=2, seed=3, env_kwargs=kwargs)
    assert np.isfinite(played.comfort).all() and np.isfinite(played.belief_sd).all()


def test_another_info_is_refused():
    with pytest.raises(InputError):
        gym.make("jawenv/Jaw-v3", info="tiny")
