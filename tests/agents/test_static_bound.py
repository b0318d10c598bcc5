"""The static bound: below what movements reach, its shares, and what it asks of an episode."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from agents.static_bound import static_bound
from jawenv.base.errors import InputError


@pytest.fixture(scope="module")
def simulation():
    env = gym.make_vec("jawenv/Jaw-v3", 6, cohort="one_sided", episode_s=10.0)
    env.reset(seed=5500)
    return env.unwrapped.simulation


@pytest.fixture(scope="module")
def bound(simulation):
    return static_bound(simulation, 10.0)


def test_no_movement_that_keeps_comfort_is_below_it(bound):
    kwargs = {"cohort": "one_sided", "episode_s": 10.0, "track_bound": False}
    played = jawenv.score(jawenv.play(jawenv.Player("refined_one_sided"), patients=6, seed=5500, env_kwargs=kwargs))
    assert (bound.log_worst < np.log(played.worst_sd)).all()
    assert bound.log_worst.mean() > np.log(played.worst_sd).mean() - 1.5


def test_a_few_poses_share_all_readings(bound):
    np.testing.assert_allclose(bound.shares.sum(axis=1), 1.0)
    for patient in range(6):
        visited = bound.visited(patient)
        assert 3 <= len(visited) <= 14
        assert [share for share, _ in visited] == sorted((share for share, _ in visited), reverse=True)


def test_more_time_tells_more_and_more_poses_hardly(simulation, bound):
    longer = static_bound(simulation, 20.0)
    assert (longer.log_worst < bound.log_worst).all()
    assert (longer.log_worst > bound.log_worst - 0.5 * np.log(2.0) - 0.1).all()


def test_there_is_none_where_disturbances_last():
    env = gym.make_vec("jawenv/JawImaged-v3", 1)
    with pytest.raises(InputError, match=r"knowledge is not exact; allowed for a static bound: exact"):
        static_bound(env.unwrapped.simulation, 10.0)
