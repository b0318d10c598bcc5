"""Copies of worlds in which actions are tried out: what they have of the truth, and what they foretell."""

import gymnasium as gym
import numpy as np
import pytest

from agents.sampling_planner import Prediction
from jawenv.envs.fork import believe
from jawenv.envs.rewards import potential


@pytest.fixture(params=["jawenv/Jaw-v3", "jawenv/JawImaged-v3"])
def env(request):
    made = gym.make_vec(request.param, num_envs=2, autoreset_mode="disabled", control="targets", episode_s=6.0)
    made.reset(seed=5000)
    for _ in range(5):
        made.step(np.full((2, 4), 0.3, np.float32))
    return made


def actions_for(number, candidates=3, steps=5):
    levels = np.linspace(-0.5, 0.5, candidates)[:, None, None]
    return np.broadcast_to(levels, (number, candidates, steps, 4)).copy()


def keys(number):
    return np.arange(2 * number, dtype=np.uint64).reshape(number, 2)


GOAL = "mixed"
ALL = np.ones(2, dtype=bool)


def test_the_believed_world_has_nothing_of_the_truth(env):
    simulation = env.unwrapped.simulation
    hidden = simulation.worlds.copy()
    of_the_patient = ("log_parameters", "muscles", "state", "lift", "jaw", "unmodelled")
    for name in (*of_the_patient, "cell_gain", "cell_offset", "turn", "cell_turn"):
        hidden["truth"][name] = np.zeros_like(hidden["truth"][name])
    seen = simulation.worlds.copy()
    believe(hidden, simulation)
    believe(seen, simulation)
    for part in ("truth", "known"):
        for name in seen[part].dtype.names:
            np.testing.assert_equal(hidden[part][name].tolist(), seen[part][name].tolist())
    states = simulation.worlds["truth"]["state"].shape[1]
    np.testing.assert_array_equal(seen["truth"]["state"], simulation.worlds["known"]["belief"]["motion"][:, :states])
    muscles = np.exp(simulation.worlds["known"]["belief"]["mean"]).reshape(2, -1, 2)
    np.testing.assert_allclose(np.unique(seen["truth"]["muscles"][0, :, 0]), np.unique(muscles[0, :, 0]))


@pytest.mark.parametrize("clairvoyant", [False, True])
def test_the_future_is_foretold(env, clairvoyant):
    simulation = env.unwrapped.simulation
    prediction = Prediction(simulation, 3, goal=GOAL, clairvoyant=clairvoyant)
    tried = actions_for(2)
    before = potential(GOAL, simulation)
    outcome = prediction.try_out(tried, ALL, keys(2))
    for step in range(tried.shape[2]):
        env.step(tried[:, 2, step].astype(np.float32))
    gained = potential(GOAL, simulation) - before
    assert not outcome.lost.any()
    # The real filter filters its first readings again and again, copies do not.
    np.testing.assert_allclose(outcome.gain[:, 2], gained, rtol=0.5)
    assert np.ptp(outcome.gain, axis=1).min() > 0.5


def test_candidates_with_the_same_actions_have_the_same_future(env):
    prediction = Prediction(env.unwrapped.simulation, 3, goal=GOAL, clairvoyant=False)
    tried = actions_for(2)
    tried[:, 1] = tried[:, 0]
    gain = prediction.try_out(tried, ALL, keys(2)).gain
    np.testing.assert_array_equal(gain[:, 0], gain[:, 1])
    assert (gain[:, 0] != gain[:, 2]).all()


def test_what_crosses_a_hard_limit_is_lost(env):
    simulation = env.unwrapped.simulation
    simulation.worlds["known"]["limits"]["side"][0] = 1e-4
    outcome = Prediction(simulation, 3, goal=GOAL, clairvoyant=False).try_out(actions_for(2), ALL, keys(2))
    assert outcome.lost[0].any() and not outcome.lost[1].any()
    assert outcome.cost[0].max() > outcome.cost[1].max()
