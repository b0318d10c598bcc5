"""A yardstick of what adapting can be worth: a maneuver for each patient, searched with the true patient at hand.

The gradient of the differentiable twin (``agents.twin``) moves the targets of the first ten seconds, for the largest sd
after them less discomfort. All worlds are searched together: one takes as long as fifty.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from agents.twin import MODEL
from jawenv.base.errors import InputError, shown
from jawenv.base.extras import needs
from jawenv.controls import DEFAULT_CONTROL, Control, takes_targets
from jawenv.device.channels import N_CHANNELS
from jawenv.envs.configuration import Configuration
from jawenv.playing.agents import Action, Array, BatchAgent, Mask, Observation, State
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import action_of

BEGINNING = "refined_one_sided"
"""The maneuver from which the search goes, and which is played after it."""
HORIZON_S = 10.0
_TOGETHER = 50
"""Worlds searched at once: the graph of an episode takes some 50 MB for each."""


class Clairvoyant(BatchAgent):
    """It goes down the twin's gradient for the true patient, before the episode.

    Args:
        name: its name.
        updates: steps of Adam.
        control: control mode of the environment.
    """

    clairvoyant = True
    description = (
        "No contestant: knows the true patient, a yardstick of what adapting can be worth. "
        f"Searches the first {HORIZON_S:g} s by the gradient of the differentiable twin."
    )

    def __init__(self, name: str = "clairvoyant", *, updates: int = 60, control: Control = DEFAULT_CONTROL) -> None:
        self.name, self.updates, self.control = name, updates, control
        self._check(control)
        self.reset(0)

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget the worlds."""
        self._simulation: Any = None

    def attach(self, env: VectorEnv[Any, Any, Any]) -> None:
        """See ``jawenv.playing.agents.introduce``."""
        unwrapped: Any = env.unwrapped
        simulation = unwrapped.simulation
        self._check(simulation.configuration.control)
        with needs(f"agent {self.name!r}", "torch", group="train"):
            from agents.twin.constants import Twin

        self._twin = Twin(simulation)
        steps, hz = simulation.configuration.steps, simulation.configuration.steps_per_s
        self._base: Array = Maneuver.named(BEGINNING).targets(np.arange(1, steps + 1) / hz).value
        self._start = self._base[: round(HORIZON_S * hz)]
        self._planned: Array = np.zeros((len(simulation.worlds), steps, N_CHANNELS))
        self._planned_at = np.full(len(simulation.worlds), -1)
        self._simulation = simulation

    def plays(self, world: Configuration) -> bool:
        """Whether it can plan in the environment of a configuration: the twin's."""
        return takes_targets(world.control) and world.model == MODEL

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
        due = np.flatnonzero(running & ((self._planned_at < 0) | (step < self._planned_at) | (step == 0)))
        for chosen in np.array_split(due, math.ceil(len(due) / _TOGETHER)) if len(due) else ():
            self._search(chosen)
        self._planned_at[due] = step[due]
        index = np.minimum(step, configuration.steps - 1)
        return action_of(self._planned[np.arange(len(rows)), index]).astype(np.float32), None

    def _search(self, chosen: NDArray[np.intp]) -> None:
        """Plan the episodes of a few worlds (N,)."""
        from agents.twin.constants import Patients
        from agents.twin.search import searched

        patients = Patients.of_worlds(self._simulation.worlds[chosen])
        starts = np.broadcast_to(self._start, (len(chosen), *self._start.shape)).copy()
        self._planned[chosen] = self._base
        self._planned[chosen, : len(self._start)] = searched(
            self._twin, patients, starts, self.updates, asked=self._simulation.asked[chosen]
        )

    def _check(self, control: object) -> None:
        if not takes_targets(control):
            raise InputError(f"agent {self.name!r}: control is {shown(control)}; allowed: targets")
