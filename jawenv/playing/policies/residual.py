"""A policy that corrects a maneuver: its actions are added to the maneuver's targets, as actions of targets control.

In the other control modes the targets are followed (`jawenv.playing.policies.following`).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.controls import Control
from jawenv.device.channels import HIGHEST, LOWEST, N_CHANNELS
from jawenv.envs.configuration import Configuration
from jawenv.envs.observation import Parts
from jawenv.playing.agents import Action, Agent, Array, Mask, Memory, Observation
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import action_of, goals_of
from jawenv.playing.policies.controller import ControlledAgent
from jawenv.playing.policies.following import DECISION_HZ
from jawenv.playing.policies.inputs import OwnParts

STEPS_SEEN = 3
N_FEATURES = STEPS_SEEN * N_CHANNELS


class BaseTargets:
    """The maneuver under a residual, step by step: the controller of policies that correct it.

    Its memory counts the decisions since the episode began.

    Args:
        maneuver: the corrected maneuver.
        scale: size of an action of 1, fraction of the patient's comfort.
        decision_hz: actions of the policy per second.
    """

    control: Control = "targets"
    steps_per_decision = 1
    n_features = N_FEATURES
    memory: np.dtype[Any] = np.dtype(np.int64)

    def __init__(self, maneuver: Maneuver, scale: float, decision_hz: float = DECISION_HZ) -> None:
        self.maneuver = maneuver
        self.scale = scale
        self.decision_hz = decision_hz

    def seen(self, rows: Observation, memory: NDArray[np.int64]) -> Observation:
        """Observations (N, size) with the `features` of the decision that is due, (N, size + 12)."""
        return np.concatenate([rows, self.features(memory)], axis=1)

    def act(self, rows: Observation, memory: NDArray[np.int64], decision: Action | None) -> Action:
        """The environment's actions (N, 4) for the policy's ``decision`` (N, 4); ``memory`` (N,) moves on by one."""
        assert decision is not None
        action = self.actions(memory, decision)
        memory += 1
        return action

    def features(self, step: NDArray[np.int64]) -> Observation:
        """Features of the maneuver for the policy.

        Args:
            step: (N,) decisions since the episode began.

        Returns:
            (N, 12) targets at the end of this decision and of the next two.
        """
        ahead = [self.targets(step + k) for k in range(STEPS_SEEN)]
        return np.concatenate(ahead, axis=1).astype(np.float32)

    def actions(self, step: NDArray[np.int64], residual: NDArray[Any]) -> Action:
        """The environment's actions.

        Args:
            step: (N,) decisions since the episode began.
            residual: (N, 4) the policy's actions, in [-1, 1].

        Returns:
            (N, 4) in [-1, 1].
        """
        targets = self.targets(step) + self.scale * np.asarray(residual, dtype=np.float64)
        return action_of(np.clip(targets, LOWEST, HIGHEST)).astype(np.float32)

    def residuals(self, step: NDArray[np.int64], action: Action) -> NDArray[Any]:
        """The policy's actions (N, 4), in [-1, 1], that come nearest to actions (N, 4) of the environment."""
        return np.clip((goals_of(action) - self.targets(step)) / self.scale, -1.0, 1.0)

    def targets(self, step: NDArray[np.int64]) -> Array:
        """Targets (N, 4) at the end of steps (N,); worlds in the same step are computed once."""
        steps, which = np.unique(step, return_inverse=True)
        return self.maneuver.targets((steps + 1) / self.decision_hz).value[which]


class ResidualPolicy(ControlledAgent):
    """A policy and the maneuver that it corrects, as one agent of targets control.

    Args:
        policy: the trained policy, which sees the environment's observation and `BaseTargets.features`.
        base: the maneuver.
        path: where the policy lies.
        parts: of the observations of the environment that it was trained in.

    Attributes:
        base: as given.
        decision_hz: its actions per second.
        path: as given.
        parts: as given.
    """

    is_trained = True

    def __init__(self, policy: Agent, base: BaseTargets, path: Path, parts: Parts) -> None:
        super().__init__(policy, base)
        self.base = base
        self.decision_hz = base.decision_hz
        self.path = path
        self.parts = parts
        self._own_parts = OwnParts(parts, path)

    def take_world(self, world: Configuration) -> None:
        """Get to know the parts of the observations, and the prior, of the worlds that are to be played."""
        self._own_parts.take(world.parts)
        super().take_world(world)

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        return super()._decide(self._own_parts(rows), memory, starts, deterministic)
