"""Agents of targets control in the other control modes: they move the jaw as in targets control."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from jawenv.envs.observation import OBSERVATION_LAYOUT, Parts
from jawenv.playing.policies.controller import ControlledAgent
from jawenv.playing.policies.following import DECISION_HZ, TargetsLaw, decision_hz

ID = "jawenv/Jaw-v3"
TARGET = OBSERVATION_LAYOUT["motor_target"]


class Script:
    """Plays a list of actions, one a decision; keeps what it is told."""

    name = "script"

    def __init__(self, actions: np.ndarray) -> None:
        self.actions, self.seen, self.starts = actions, [], []

    def reset(self, num_envs: int, seed: int | None = None) -> None: ...

    def predict(self, observation, state=None, episode_start=None, deterministic=True):  # noqa: ANN001, ANN201
        self.seen.append(observation)
        self.starts.append(episode_start)
        count = 0 if state is None else int(state[0])
        goals = np.repeat(self.actions[count][None], len(observation), axis=0).astype(np.float32)
        return goals, (np.array(count + 1),)


def played(control: str, agent: Any, steps: int, worlds: int = 1) -> np.ndarray:
    """Observations (steps, N, size) of patients 3 and on."""
    env = gym.make_vec(ID, num_envs=worlds, control=control, autoreset_mode="disabled")
    observation, _ = env.reset(seed=3)
    agent.reset(worlds)
    seen, state, start = [], None, np.ones(worlds, dtype=bool)
    for _ in range(steps):
        action, state = agent.predict(observation, state, start)
        observation, *_ = env.step(action)
        start = np.zeros(worlds, dtype=bool)
        seen.append(observation)
    return np.array(seen)


ABRUPT = np.random.default_rng(0).uniform(-0.8, 0.8, (30, 4)) * [0.2, 1.0, 1.0, 1.0] - [0.4, 0.0, 0.0, 0.0]
SMOOTH = np.outer(np.sin(np.arange(30) / 5.0), [0.3, 0.5, 0.1, 0.0]) - [0.4, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("control", "goals", "tolerance"), [("trajectory", ABRUPT, 0.02), ("force", SMOOTH, 0.3)], ids=["servo", "thrust"]
)
def test_the_jaw_moves_as_in_targets_control(control: str, goals: np.ndarray, tolerance: float) -> None:
    """By a servo the motion is the same; by thrusts the jaw follows late, as the muscles' stiffness allows."""
    told, followed = Script(goals), Script(goals)
    inside = played("targets", told, 30)
    outside = played(control, ControlledAgent(followed, TargetsLaw(control)), 120)
    jaw = OBSERVATION_LAYOUT["jaw"]
    np.testing.assert_allclose(outside[3::4, 0, jaw][:, :2], inside[:, 0, jaw][:, :2], atol=tolerance)
    assert np.ptp(inside[:, 0, jaw][:, 1]) > 0.3
    np.testing.assert_allclose(np.array(followed.seen)[:, 0, TARGET], np.array(told.seen)[:, 0, TARGET], atol=0.02)


def observations(worlds: int) -> np.ndarray:
    return np.random.default_rng(1).uniform(-0.1, 0.1, (worlds, Parts().size)).astype(np.float32)


def test_the_agent_is_asked_when_a_decision_is_due() -> None:
    script = Script(np.zeros((5, 4)))
    agent, seen = ControlledAgent(script, TargetsLaw("force")), observations(2)
    for step in range(9):
        agent.predict(seen, episode_start=np.array([step == 0, step in (0, 6)]))
    assert [starts.tolist() for starts in script.starts] == [[True, True], [False, False], [False, True]]


def test_a_world_that_begins_between_two_decisions_keeps_still() -> None:
    agent, seen = ControlledAgent(Script(np.full((5, 4), 0.5)), TargetsLaw("trajectory")), observations(2)
    for _ in range(2):
        _, state = agent.predict(seen)
    assert state is not None and (abs(state.of_worlds[0]["rate"]) > 0).all()
    _, state = agent.predict(seen, state, np.array([False, True]))
    trackers = state.of_worlds[0]
    assert (
        (trackers["target"][1] == 0).all() and (trackers["rate"][1] == 0).all() and (trackers["target"][0] != 0).all()
    )


def test_targets_stay_within_comfort_whatever_is_asked_for() -> None:
    law = TargetsLaw("force")
    trackers = np.zeros(2, law.memory)
    for extreme in (9.0, -9.0):
        for _ in range(20):
            for step in range(law.steps_per_decision):
                goal = np.full((2, 4), extreme) if step == 0 else None
                assert (abs(law.act(observations(2), trackers, goal)) <= 1.0).all()
        ends = [1.0] * 4 if extreme > 0 else [0.0, -1.0, -1.0, -1.0]
        np.testing.assert_allclose(trackers["target"], [ends, ends], atol=1e-6)


def test_rates() -> None:
    assert TargetsLaw("force").steps_per_decision == 4 and TargetsLaw("force", 50.0).steps_per_decision == 10
    assert decision_hz({"control": "force", "control_hz": 50.0}) == DECISION_HZ == decision_hz({"control": "targets"})
    assert decision_hz({"control": "targets", "control_hz": 4.0}) == 4.0
