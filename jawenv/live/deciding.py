"""An agent of targets control that drives a page, which makes more control steps a second than the agent decides."""

from __future__ import annotations

import numpy as np

from jawenv.controls import CONTROLS
from jawenv.device.channels import FASTEST_TARGET
from jawenv.playing.agents import Agent, Array, Observation, State
from jawenv.playing.maneuvers.maneuver import goals_of

_DECISION_HZ = CONTROLS["targets"].steps_per_s


class Deciding:
    """Asks an agent for targets as often as in its own environment; between two decisions they move evenly.

    Args:
        name: what the page calls it.
        agent: of targets control, one world.
        control_hz: control steps per second of the page, a multiple of the agent's.

    Attributes:
        name: as given.
    """

    def __init__(self, name: str, agent: Agent, control_hz: float) -> None:
        self.name = name
        self._agent = agent
        self._every, self._reach = round(control_hz / _DECISION_HZ), np.array(FASTEST_TARGET) / control_hz
        self.begin()

    def begin(self) -> None:
        """Forget; the next step is the first of an episode."""
        self._agent.reset(1)
        self._step, self._goal = 0, np.zeros(len(FASTEST_TARGET))
        self._state: State = None

    def try_out(self, observation: Observation) -> None:
        """Let the agent answer an observation (size,), and forget it."""
        self._decide(observation)
        self.begin()

    def next(self, observation: Observation, asked: Array) -> Array:
        """Targets (4,) for the end of this control step.

        Args:
            observation: (size,) at its begin.
            asked: (4,) targets for the end of the step before.
        """
        since = self._step % self._every
        if since == 0:
            self._goal = self._decide(observation)
        self._step += 1
        move = (self._goal - asked) / (self._every - since)
        targets: Array = asked + np.clip(move, -self._reach, self._reach)
        return targets

    def _decide(self, observation: Observation) -> Array:
        action, self._state = self._agent.predict(observation[None], self._state, np.array([self._step == 0]))
        return goals_of(np.asarray(action)[0])
