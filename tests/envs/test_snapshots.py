"""What is restored has the future of the snapshot, bit for bit, in every model, however often and wherever."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest
from test_copies import actions

import jawenv
from jawenv.envs.registration import ENVIRONMENTS


def future(env, commands):
    """Steps, a reset that goes on with the random numbers, and a step of the next episode."""
    seen = [env.step(action) for action in commands]
    return [*seen, env.reset(), env.step(commands[0])]


def assert_same_futures(one, other):
    """Any nesting of what ``step`` and ``reset`` return; observations of ended worlds are arrays in an array."""
    if isinstance(one, dict):
        assert list(one) == list(other)
        one, other = list(one.values()), list(other.values())
    if isinstance(one, list | tuple) or (isinstance(one, np.ndarray) and one.dtype == object):
        for mine, theirs in zip(one, other, strict=True):
            assert_same_futures(mine, theirs)
    else:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("env_id", ENVIRONMENTS)
def test_the_single_form_has_the_future_of_its_snapshot(env_id):
    env, untouched, twin = (gym.make(env_id, track_bound=True) for _ in range(3))
    for each in (env, untouched):
        each.reset(seed=3)
    for (action,) in actions(1, 7):
        env.step(action), untouched.step(action)
    snapshot = env.unwrapped.snapshot()
    ahead = actions(1, 12, seed=1)[:, 0]
    expected = future(untouched, ahead)
    for _ in range(2):
        future(env, actions(1, 5, seed=2)[:, 0])  # somewhere else, into another episode
        env.unwrapped.restore(snapshot)
        assert_same_futures(future(env, ahead), expected)
    twin.reset(seed=99)
    twin.unwrapped.restore(pickle.loads(pickle.dumps(snapshot)))
    assert_same_futures(future(twin, ahead), expected)


MODES = [("jawenv/Jaw-v3", mode) for mode in ("next_step", "disabled")]  # how episodes end is the same in every model


@pytest.mark.parametrize(("env_id", "mode"), [(env_id, "same_step") for env_id in ENVIRONMENTS] + MODES)
def test_the_vector_form_has_the_future_of_its_snapshot(env_id, mode):
    """Through the end of an episode, into the next where worlds begin it by themselves."""
    env, untouched = (gym.make_vec(env_id, num_envs=2, episode_s=1.0, autoreset_mode=mode) for _ in range(2))
    for each in (env, untouched):
        each.reset(seed=3)
        for action in actions(2, 3):
            each.step(action)
    snapshot = env.snapshot()
    ahead = actions(2, 4, seed=1)
    expected = future(untouched, ahead)
    for _ in range(2):
        future(env, actions(2, 3, seed=2))
        env.restore(snapshot)
        assert_same_futures(future(env, ahead), expected)


def test_a_snapshot_before_the_first_reset_asks_for_one():
    env = gym.make("jawenv/JawHinge-v3").unwrapped
    snapshot = env.snapshot()
    env.reset(seed=0)
    env.restore(snapshot)
    with pytest.raises(gym.error.ResetNeeded):
        env.step(np.zeros(4, dtype=np.float32))


def test_pictures_go_back_as_well(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gym.make("jawenv/JawHinge-v3", render_mode="rgb_array").unwrapped
    env.reset(seed=0)
    env.step(np.full(4, 0.3, dtype=np.float32))
    snapshot, picture = env.snapshot(), env.render()
    for _ in range(3):
        env.step(np.full(4, -0.3, dtype=np.float32))
    assert not np.array_equal(env.render(), picture)
    env.restore(snapshot)
    np.testing.assert_array_equal(env.render(), picture)
    env.close()


@pytest.mark.parametrize(
    "other",
    [
        {"reward": "worst"},
        {"comfort_weight": 1.0},
        {"control": "force"},
        {"estimator": "none"},
        {"cohort": "wide"},
        {"track_bound": True},
        {"record": True},
        {"episode_s": 10.0},
        {"device": {"full_scale_N": 5.0}},
        {"reality": {"creep_share": 0.3}},
        {"id": "jawenv/JawSides-v3"},
    ],
)
def test_a_snapshot_of_another_environment_is_refused_and_nothing_changes(other):
    env, strange = gym.make("jawenv/Jaw-v3").unwrapped, gym.make(**{"id": "jawenv/Jaw-v3", **other}).unwrapped
    env.reset(seed=0)
    before = env.simulation.worlds.tobytes()
    with pytest.raises(jawenv.InputError):
        env.restore(strange.snapshot())
    assert env.simulation.worlds.tobytes() == before


def test_what_is_no_snapshot_of_this_form_is_refused():
    env, vec = gym.make("jawenv/Jaw-v3").unwrapped, gym.make_vec("jawenv/Jaw-v3", num_envs=1)
    with pytest.raises(jawenv.InputError):
        env.restore({})
    with pytest.raises(jawenv.InputError):
        vec.restore(env.snapshot())
    with pytest.raises(jawenv.InputError):
        vec.restore(gym.make_vec("jawenv/Jaw-v3", num_envs=2).snapshot())
    assert copy.deepcopy(vec).restore(vec.snapshot()) is None
