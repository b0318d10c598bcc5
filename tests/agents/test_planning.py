"""Planners: what they need, that they are better for it, and that planning changes nothing of what is real."""

from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest

import agents
import jawenv
from agents.planners import PLANNERS
from agents.planning import Plan, Planner
from jawenv.errors import InputError
from jawenv.playing.protocol import Agent, Planning
from tests.recorded import Actions

KWARGS = {"control": "targets", "episode_s": 2.0}
QUICK = {
    "myopic": {"candidates": 6},
    "receding_horizon": {"candidates": 8, "rounds": 2, "elites": 2, "horizon_s": 2.0},
    "clairvoyant_myopic": {"candidates": 6},
}
SAMPLING = Plan("sampling", "Sampled.", 2.0, 8, rounds=2, elites=2, maneuvers=("refined_one_sided",))


def vector(number=2, **kwargs):
    return gym.make_vec("jawenv/Jaw-v3", num_envs=number, autoreset_mode="disabled", **{**KWARGS, **kwargs})


class Replayed:
    """Plays given actions (T, N, 4)."""

    name = "replayed"

    def __init__(self, actions):
        self.actions = iter(actions)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return next(self.actions), None


def quick(name):
    """A named planner that tries less, and one that has no name."""
    if name == "sampling":
        return Planner(SAMPLING)
    return PLANNERS[name]._replace(plan=replace(PLANNERS[name].plan, **QUICK[name])).planner("targets")


def actions_of(agent, **kwargs):
    """What it is played to, and its actions (T, N, 4)."""
    watched = Actions()
    return jawenv.play(agent, env_kwargs=KWARGS, on_step=watched, **kwargs), np.array(watched.actions)


def test_every_planner_has_a_name_and_says_what_it_does():
    for name in PLANNERS:
        agent = agents.load_agent(name, control="targets")
        assert isinstance(agent, Agent) and isinstance(agent, Planning) and agent.name == name
        assert agent.description.startswith("No contestant") == name.startswith("clairvoyant_")


def test_what_a_planner_cannot_do_without_is_named():
    agent = quick("myopic")
    with pytest.raises(InputError):
        agent.predict(np.zeros((2, 59), np.float32))
    with pytest.raises(InputError):
        jawenv.play(agent, patients=1, seed=5000, env_kwargs={"control": "trajectory", "episode_s": 1.0})
    env = vector(1)
    env.reset(seed=5000)
    agent.attach(env)
    with pytest.raises(InputError):
        agent.predict(np.zeros((2, 59), np.float32))


def test_the_fewest_candidates_are_those_that_are_always_tried():
    for name, fewest in (("myopic", 1), ("receding_horizon", 3)):
        plan, kind = PLANNERS[name]
        agent = kind(replace(plan, candidates=fewest, elites=1, horizon_s=1.0))
        assert jawenv.play(agent, patients=1, seed=5000, env_kwargs=KWARGS).valid.all()


@pytest.mark.parametrize("name", (*QUICK, "sampling"))
@pytest.mark.parametrize("options", [{"track_bound": True, "record": True, "reward": "bound", "cohort": "wide"}, {}])
def test_planning_changes_nothing_of_the_real_worlds(name, options):
    agent, kwargs = quick(name), {"track_bound": False, **KWARGS, **options}
    watched = Actions()
    planned = jawenv.play(agent, patients=2, seed=5000, env_kwargs=kwargs, on_step=watched)
    replayed = jawenv.play(Replayed(watched.actions), patients=2, seed=5000, env_kwargs=kwargs)
    np.testing.assert_array_equal(planned.belief_cov, replayed.belief_cov)
    np.testing.assert_array_equal(planned.belief_mean, replayed.belief_mean)
    np.testing.assert_array_equal(planned.bound_sd, replayed.bound_sd)
    assert agent.decisions == 4 and agent.ms_per_decision > 0.0
    assert np.ptp(watched.actions, axis=0).max() > 0.1


@pytest.mark.parametrize("name", ["receding_horizon", "sampling"])
def test_a_world_s_plan_depends_on_no_other_world(name):
    _, both = actions_of(quick(name), patients=2, seed=5000)
    _, one = actions_of(quick(name), patients=1, seed=5001)
    np.testing.assert_array_equal(both[:, 1], one[:, 0])


def test_the_mean_of_many_small_gains_goes_further_than_the_best_of_them(monkeypatch):
    """The goal lies beside the maneuver, by as much at every moment."""
    far = {}
    for agent in (quick("receding_horizon"), Planner(replace(SAMPLING, candidates=24, rounds=4, elites=6))):
        agent.plan = replace(agent.plan, candidates=24, rounds=4, elites=6)
        env = vector(1)
        env.reset(seed=5000)
        agent.reset(1, 0)
        agent.attach(env)
        goal = np.array(agent._continued(np.zeros(4), 0)[0]) + np.array([0.1, 0.2, 0.05, 0.2])
        monkeypatch.setattr(agent, "_judge", lambda tried, *_, goal=goal: -((tried - goal) ** 2).sum(axis=(2, 3)))
        agent.predict(np.zeros((1, 59), np.float32))
        far[agent.name] = np.linalg.norm(agent._planned[0] - goal)
    assert far["receding_horizon"] < 0.8 * far["sampling"]


def test_a_new_episode_is_planned_from_its_start():
    agent, env = quick("myopic"), vector(1)
    first, _ = env.reset(seed=5000)
    agent.reset(1, 3)
    agent.attach(env)
    begun, _ = agent.predict(first)
    for _ in range(3):
        env.step(begun)
    again, _ = env.reset(seed=5000)
    np.testing.assert_array_equal(agent.predict(again)[0], begun)
    assert agent.decisions == 2


def test_a_planner_learns_more_than_holding_still():
    kwargs = {**KWARGS, "episode_s": 3.0}
    worst = {}
    for agent in (quick("myopic"), agents.load_agent("hold_still", control="targets")):
        worst[agent.name] = jawenv.play(agent, patients=2, seed=5000, env_kwargs=kwargs).belief_sd[:, -1].max(axis=1)
    assert (worst["myopic"] < 0.6 * worst["hold_still"]).all()
