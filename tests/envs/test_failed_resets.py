"""A reset that raises leaves an environment as it was; and what ``reset`` draws from ``np_random``."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv

ID = "jawenv/Jaw-v3"
LIMP = {"F_o_N": dict.fromkeys(jawenv.MUSCLE_NAMES, 0.01), "b": dict.fromkeys(jawenv.MUSCLE_NAMES, 1.0)}
FIRM = {"F_o_N": dict.fromkeys(jawenv.MUSCLE_NAMES, 1.0), "b": dict.fromkeys(jawenv.MUSCLE_NAMES, 7.0)}
STRANGE = {"F_o_N": {"tongue": 1.0}, "b": {"tongue": 1.0}}
ACTION = np.array([0.3, 0.3, 0.1, 0.1], dtype=np.float32)


@pytest.mark.parametrize("seed", [None, 9])
@pytest.mark.parametrize("patient", [LIMP, STRANGE])
@pytest.mark.parametrize("env_id", [ID, "jawenv/JawSagittal-v3"])
def test_a_failed_reset_changes_nothing(env_id, patient, seed):
    env, untouched = gym.make(env_id, record=True).unwrapped, gym.make(env_id, record=True).unwrapped
    for each in (env, untouched):
        each.reset(seed=1)
        for _ in range(5):
            each.step(ACTION)
    if patient is LIMP and env_id != ID:
        names = env.simulation.cohort.muscles.names
        patient = {name: dict.fromkeys(names, 0.01) for name in ("F_o_N", "b")}
    with pytest.raises(jawenv.InputError):
        env.reset(seed=seed, options={"patient": patient})
    assert env.simulation.worlds.tobytes() == untouched.simulation.worlds.tobytes()
    assert env.simulation.ticks.tobytes() == untouched.simulation.ticks.tobytes()
    assert env.simulation.paths.tobytes() == untouched.simulation.paths.tobytes()
    assert env.np_random_seed == untouched.np_random_seed == 1
    for _ in range(3):
        for mine, theirs in zip(env.step(ACTION)[:2], untouched.step(ACTION)[:2], strict=True):
            np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_array_equal(env.reset()[0], untouched.reset()[0])


@pytest.mark.parametrize("seed", [None, 9])
def test_a_failed_reset_of_many_changes_none(seed):
    env, untouched = (gym.make_vec(ID, num_envs=3) for _ in range(2))
    actions = np.tile(ACTION, (3, 1))
    for each in (env, untouched):
        each.reset(seed=1)
        each.step(actions)
    with pytest.raises(jawenv.InputError):
        env.reset(seed=seed, options={"patients": [FIRM, None, LIMP]})
    assert env.simulation.worlds.tobytes() == untouched.simulation.worlds.tobytes()
    assert env.np_random_seed == untouched.np_random_seed == (1, 2, 3)
    for mine, theirs in zip(env.step(actions)[:4], untouched.step(actions)[:4], strict=True):
        np.testing.assert_array_equal(mine, theirs)
    np.testing.assert_array_equal(env.reset()[0], untouched.reset()[0])


def test_a_first_reset_that_fails_is_none():
    for env, options in (
        (gym.make(ID).unwrapped, {"patient": LIMP}),
        (gym.make_vec(ID, num_envs=2), {"patients": [None, LIMP]}),
    ):
        with pytest.raises(jawenv.InputError):
            env.reset(seed=0, options=options)
        with pytest.raises(gym.error.ResetNeeded):
            env.step(np.zeros((2, 4))[: getattr(env, "num_envs", 1)].squeeze())


def test_a_generator_that_is_set_reaches_the_next_episode():
    env, other = gym.make(ID).unwrapped, gym.make(ID).unwrapped
    env.reset(seed=1)
    for each in (env, other):
        each.np_random = np.random.default_rng(7)
    first, info = env.reset()
    np.testing.assert_array_equal(first, other.reset()[0])
    assert env.np_random_seed == -1
    env.np_random = np.random.default_rng(8)
    assert not np.array_equal(env.reset()[1]["truth"], info["truth"])
    env.reset(seed=5)
    assert env.np_random_seed == 5


def test_generators_of_the_vector_form():
    env = gym.make_vec(ID, num_envs=2)
    first, _ = env.reset()
    again, _ = env.reset(seed=list(env.np_random_seed))
    np.testing.assert_array_equal(first, again)
    env.reset(seed=4, options={"reset_mask": np.array([False, True])})
    assert env.np_random_seed[1] == 5
    single = gym.make(ID).unwrapped
    single.np_random, env.np_random = np.random.default_rng(7), np.random.default_rng(7)
    together, _ = env.reset()
    np.testing.assert_array_equal(together, [single.reset()[0], single.reset()[0]])
    assert env.np_random_seed == (-1, -1)
    assert len(env.np_random) == 2
