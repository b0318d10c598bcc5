"""A yardstick of what adapting can be worth: a maneuver for each patient, searched with the true patient at hand.

The gradient of the differentiable twin (``agents.twin``) moves the targets of the first ten seconds, for the largest sd
after them less discomfort. All worlds are searched together: one takes as long as fifty.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.planning import Planner
from agents.twin import MODEL
from jawenv.base.extras import needs
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.envs.configuration import Configuration
from jawenv.playing.agents import Array, Mask
from jawenv.playing.maneuvers import Maneuver

BEGINNING = "refined_one_sided"
"""The maneuver from which the search goes, and which is played after it."""
HORIZON_S = 10.0


class Clairvoyant(Planner):
    """It goes down the twin's gradient for the true patient, before the episode.

    Args:
        name: its name.
        updates: steps of Adam.
        control: control mode of the environment.
    """

    together = 50
    replan_s = math.inf

    def __init__(self, name: str = "clairvoyant", *, updates: int = 60, control: Control = DEFAULT_CONTROL) -> None:
        self.updates = updates
        text = f"Searches the first {HORIZON_S:g} s by the gradient of the differentiable twin."
        super().__init__(name, text, clairvoyant=True, control=control)

    def plays(self, world: Configuration) -> bool:
        """Whether it can plan in the environment of a configuration: the twin's."""
        return super().plays(world) and world.model == MODEL

    def _begin(self, simulation: Any) -> None:
        with needs(f"agent {self.name!r}", "torch", group="train"):
            from agents.twin.constants import Twin

        self._twin = Twin(simulation)
        whole = np.arange(1, self._planned.shape[1] + 1) / self._hz
        self._base: Array = Maneuver.named(BEGINNING).targets(whole).value

    def _search(self, step: Array, due: Mask) -> None:
        every = np.flatnonzero(due)
        for chosen in np.array_split(every, math.ceil(len(every) / self.together)):
            self._search_for(chosen)

    def _search_for(self, chosen: NDArray[np.intp]) -> None:
        """The same of a few worlds (N,): the graph of an episode takes some 50 MB for each."""
        from agents.twin.constants import Patients
        from agents.twin.search import searched

        patients = Patients.of_worlds(self._simulation.worlds[chosen])
        base = self._base[: round(HORIZON_S * self._hz)]
        starts = np.broadcast_to(base, (len(chosen), *base.shape)).copy()
        self._planned[chosen] = self._base
        self._planned[chosen, : len(base)] = searched(
            self._twin, patients, starts, self.updates, asked=self._simulation.asked[chosen]
        )
