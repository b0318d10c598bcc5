"""Planners: what they need, that they are better for it, and that planning changes nothing of what is real."""

import gymnasium as gym
import numpy as np
import pytest

import agents
import jawenv
from agents.clairvoyant import Clairvoyant
from agents.registry import PLANNERS
from jawenv.base.errors import InputError
from jawenv.playing.agents import Agent
from tests.recorded import Actions

KWARGS = {"control": "targets", "episode_s": 2.0}
QUICK = {"clairvoyant": lambda: Clairvoyant(updates=2)}


def vector(number=2, **kwargs):
    return gym.make_vec("jawenv/Jaw-v3", num_envs=number, autoreset_mode="disabled", **{**KWARGS, **kwargs})


class Replayed:
    """Plays given actions (T, N, 4)."""

    name = "replayed"

    def __init__(self, actions):
        self.actions = iter(actions)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return next(self.actions), None


def actions_of(agent, **kwargs):
    """What it is played to, and its actions (T, N, 4)."""
    watched = Actions()
    return jawenv.play(agent, env_kwargs=KWARGS, on_step=watched, **kwargs), np.array(watched.actions)


def test_every_planner_has_a_name_and_says_what_it_does():
    for name in PLANNERS:
        agent = agents.load_agent(name, control="targets")
        assert isinstance(agent, Agent) and hasattr(agent, "attach") and agent.name == name
        assert agent.description.startswith("No contestant") == name.startswith("clairvoyant")


def test_what_a_planner_cannot_do_without_is_named():
    agent = QUICK["clairvoyant"]()
    with pytest.raises(InputError):
        agent.predict(np.zeros((2, 59), np.float32))
    with pytest.raises(InputError):
        jawenv.play(agent, patients=1, seed=5000, env_kwargs={"control": "trajectory", "episode_s": 1.0})
    env = vector(1)
    env.reset(seed=5000)
    agent.attach(env)
    with pytest.raises(InputError):
        agent.predict(np.zeros((2, 59), np.float32))


@pytest.mark.parametrize("env_id", ["jawenv/JawHinge-v3", "jawenv/JawPortions-v3"])
def test_the_twin_is_of_one_model(env_id):
    with pytest.raises(InputError):
        jawenv.play(QUICK["clairvoyant"](), patients=1, seed=5000, env_id=env_id, env_kwargs=KWARGS)


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("options", [{"track_bound": True, "record": True, "reward": "bound", "cohort": "wide"}, {}])
def test_planning_changes_nothing_of_the_real_worlds(name, options):
    agent, kwargs = QUICK[name](), {"track_bound": False, **KWARGS, **options}
    watched = Actions()
    planned = jawenv.play(agent, patients=2, seed=5000, env_kwargs=kwargs, on_step=watched)
    replayed = jawenv.play(Replayed(watched.actions), patients=2, seed=5000, env_kwargs=kwargs)
    np.testing.assert_array_equal(planned.belief_cov, replayed.belief_cov)
    np.testing.assert_array_equal(planned.belief_mean, replayed.belief_mean)
    np.testing.assert_array_equal(planned.bound_sd, replayed.bound_sd)
    assert np.ptp(watched.actions, axis=0).max() > 0.1


@pytest.mark.parametrize("name", ["clairvoyant"])
def test_a_world_s_plan_depends_on_no_other_world(name):
    _, both = actions_of(QUICK[name](), patients=2, seed=5000)
    _, one = actions_of(QUICK[name](), patients=1, seed=5001, agent_seed=1)
    np.testing.assert_array_equal(both[:, 1], one[:, 0])


def test_a_new_episode_is_planned_from_its_start():
    agent, env = QUICK["clairvoyant"](), vector(1)
    first, _ = env.reset(seed=5000)
    agent.reset(1, 3)
    agent.attach(env)
    begun, _ = agent.predict(first)
    for _ in range(3):
        env.step(begun)
    again, _ = env.reset(seed=5000)
    np.testing.assert_array_equal(agent.predict(again)[0], begun)


def test_a_planner_learns_more_than_holding_still():
    kwargs = {**KWARGS, "episode_s": 3.0}
    worst = {}
    for agent in (QUICK["clairvoyant"](), agents.load_agent("hold_still", control="targets")):
        worst[agent.name] = jawenv.play(agent, patients=2, seed=5000, env_kwargs=kwargs).belief_sd[:, -1].max(axis=1)
    assert (worst["clairvoyant"] < 0.6 * worst["hold_still"]).all()
