"""Planners: agents that search for the next targets from the filter's belief, and plan again after a second.

They are certainty-equivalent: the belief's mean is taken for the truth, so that they do not probe on purpose, but what
they do follows from what was learnt of this patient. A clairvoyant one takes the truth for the truth. It is no
contestant, but a yardstick of what adapting to the patient can be worth.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv

from jawenv.base.errors import InputError, shown
from jawenv.controls import DEFAULT_CONTROL, Control, takes_targets
from jawenv.device.channels import N_CHANNELS
from jawenv.envs.configuration import Configuration
from jawenv.playing.agents import Action, Array, BatchAgent, Mask, Observation, State
from jawenv.playing.maneuvers.maneuver import action_of

CLAIRVOYANT = "No contestant: knows the true patient, a yardstick of what adapting can be worth. "
"""The description of a clairvoyant planner begins with it."""


class Planner(BatchAgent, ABC):
    """An agent that plans for each of the worlds it is attached to.

    Args:
        name: its name.
        description: a sentence on its method.
        clairvoyant: whether it plans for the true patient.
        control: control mode of the environment.

    Attributes:
        together: worlds that are best planned for at the same time.
        replan_s: how long it follows a plan.
    """

    together: int
    replan_s = 1.0

    def __init__(
        self, name: str, description: str, *, clairvoyant: bool = False, control: Control = DEFAULT_CONTROL
    ) -> None:
        self.name, self.clairvoyant, self.control = name, clairvoyant, control
        self.description = CLAIRVOYANT * clairvoyant + description
        self._check(control)
        self.reset(0)

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget the worlds; without a seed the plans differ from run to run."""
        self._seed = int(np.random.default_rng().integers(2**31)) if seed is None else seed
        self._simulation: Any = None

    def attach(self, env: VectorEnv[Any, Any, Any]) -> None:
        """See ``jawenv.playing.agents.Planning.attach``."""
        unwrapped: Any = env.unwrapped
        simulation = unwrapped.simulation
        self._check(simulation.configuration.control)
        self._hz = simulation.configuration.steps_per_s
        number = len(simulation.worlds)
        self._planned: Array = np.zeros((number, simulation.configuration.steps, N_CHANNELS))
        self._planned_at = np.full(number, -1)
        self._begin(simulation)
        self._simulation = simulation

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        # Only the attached environment is read; the observations give the number of worlds.
        if self._simulation is None:
            raise InputError(f"agent {self.name!r}: no environment; allowed: attach(env) before predict, as play does")
        worlds, configuration = self._simulation.worlds, self._simulation.configuration
        if len(rows) != len(worlds):
            raise InputError(f"observation has {len(rows)} worlds; allowed: the {len(worlds)} of the environment")
        filters, violated = worlds["known"], worlds["truth"]["violated"]
        step = (filters["tick"] // configuration.ticks_per_step).astype(np.intp)
        running = (step < configuration.steps) & (violated == 0) & np.isfinite(filters["log_det"])
        since = step - self._planned_at
        due = running & ((self._planned_at < 0) | (since < 0) | (since >= self.replan_s * self._hz - 0.5) | (step == 0))
        if due.any():
            self._search(step, due)
            self._planned_at[due] = step[due]
        index = np.minimum(step, configuration.steps - 1)
        return action_of(self._planned[np.arange(len(rows)), index]).astype(np.float32), None

    @abstractmethod
    def _begin(self, simulation: Any) -> None:
        """Get ready for the worlds of a simulation."""

    @abstractmethod
    def _search(self, step: Array, due: Mask) -> None:
        """Fill the rows of ``_planned`` of the worlds that are due (N,) from their steps (N,) on."""

    def plays(self, world: Configuration) -> bool:
        """Whether it can plan in the environment of a configuration."""
        return takes_targets(world.control)

    def _check(self, control: object) -> None:
        if not takes_targets(control):
            raise InputError(f"agent {self.name!r}: control is {shown(control)}; allowed: targets")
