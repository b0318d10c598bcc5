"""A policy that corrects a maneuver: its actions are added to the maneuver's targets, as actions of targets control.

In the other control modes `agents.following.Following` plays it.

`BaseTargets` holds all that training and agent have in common: what the policy sees beside the environment's
observation, and what becomes of its action.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from agents.following import DECISION_HZ
from jawenv.controls import Control
from jawenv.device.channels import HIGHEST, LOWEST, N_CHANNELS
from jawenv.files import InputModel, Number
from jawenv.playing.agents import Memory, Remembering, check_size
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import SUFFIXES
from jawenv.playing.maneuvers.player import action_of, goals_of
from jawenv.playing.protocol import Action, Agent, Array, Mask, Observation

STEPS_SEEN = 3
N_FEATURES = STEPS_SEEN * N_CHANNELS
BASE_FILE = "base_maneuver.json"
"""Copy of the maneuver in a run's folder: what it was when the policy was trained on it."""


class Residual(InputModel):
    """What a policy corrects, and how far.

    Attributes:
        maneuver: name of one that comes with jawenv, or a maneuver file.
        scale: what an action of 1 adds to the maneuver's target, as a fraction of the patient's comfort.
    """

    maneuver: Annotated[str, Field(min_length=1)]
    scale: Annotated[Number, Field(gt=0.0, le=2.0)] = 0.5

    def load_maneuver(self, folder: Path | None = None) -> Maneuver:
        """The maneuver; where a run's folder holds a copy of it, that one.

        Raises:
            InputError: no such maneuver, or a damaged file.
        """
        file = self.maneuver_file(folder)
        return Maneuver.named(self.maneuver) if file is None else Maneuver.load(file)

    def maneuver_file(self, folder: Path | None = None) -> Path | None:
        """The file that `load_maneuver` reads; None for a maneuver that comes with jawenv."""
        if folder is not None and (folder / BASE_FILE).exists():
            return folder / BASE_FILE
        return Path(self.maneuver) if Path(self.maneuver).suffix in SUFFIXES else None


class BaseTargets:
    """The maneuver under a residual, step by step.

    Args:
        maneuver: what is corrected.
        scale: what an action of 1 adds, fraction of the patient's comfort.
        decision_hz: actions of the policy per second.
    """

    def __init__(self, maneuver: Maneuver, scale: float, decision_hz: float = DECISION_HZ) -> None:
        self.maneuver = maneuver
        self.scale = scale
        self.decision_hz = decision_hz

    def features(self, step: NDArray[np.int64]) -> Observation:
        """What the policy sees of the maneuver.

        Args:
            step: (N,) decisions since the episode began.

        Returns:
            (N, 12) targets at the end of this decision and of the next two.
        """
        ahead = [self._at_end(step + k) for k in range(STEPS_SEEN)]
        return np.concatenate(ahead, axis=1).astype(np.float32)

    def actions(self, step: NDArray[np.int64], residual: NDArray[Any]) -> Action:
        """The environment's actions.

        Args:
            step: (N,) decisions since the episode began.
            residual: (N, 4) the policy's actions, in [-1, 1].

        Returns:
            (N, 4) in [-1, 1].
        """
        wanted = self._at_end(step) + self.scale * np.asarray(residual, dtype=np.float64)
        return action_of(np.clip(wanted, LOWEST, HIGHEST)).astype(np.float32)

    def residuals(self, step: NDArray[np.int64], action: Action) -> NDArray[Any]:
        """The policy's actions (N, 4), in [-1, 1], that come nearest to actions (N, 4) of the environment."""
        return np.clip((goals_of(action) - self._at_end(step)) / self.scale, -1.0, 1.0)

    def _at_end(self, step: NDArray[np.int64]) -> Array:
        """Targets (N, 4) at the end of steps (N,); worlds in the same step are computed once."""
        steps, which = np.unique(step, return_inverse=True)
        return self.maneuver.targets((steps + 1) / self.decision_hz).value[which]


class ResidualPolicy(Remembering):
    """A policy and the maneuver that it corrects, as one agent of targets control.

    Args:
        policy: the trained policy, which sees the environment's observation and `BaseTargets.features`.
        base: the maneuver.
        path: the policy's checkpoint.
        observation_size: of the environment.

    Attributes:
        name: the policy's.
        control: "targets".
        policy: as given.
        base: as given.
        decision_hz: its actions per second.
        path: as given.
        observation_size: as given.
    """

    control: Control = "targets"
    _remembered = (np.int64,)  # decisions since the episode began

    def __init__(self, policy: Agent, base: BaseTargets, path: Path, observation_size: int) -> None:
        self.name = policy.name
        self.base = base
        self.decision_hz = base.decision_hz
        self.path = path
        self.observation_size = observation_size
        self.policy = policy

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget all worlds; seed the draws of a stochastic policy."""
        super().reset(num_envs, seed)
        self.policy.reset(num_envs, seed)

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        check_size(rows, self.observation_size, self.path)
        (step,) = memory.of_worlds
        if memory.shared is None:
            self.policy.reset(len(rows))
        (inner,) = memory.shared or (None,)
        seen = np.concatenate([rows, self.base.features(step)], axis=1)
        residual, after = self.policy.predict(seen, inner, starts, deterministic)
        return self.base.actions(step, residual), Memory((step + 1,), (after,))
