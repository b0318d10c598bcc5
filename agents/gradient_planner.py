"""A planner by gradient: the rest of the episode is searched for the patient as he is believed to be.

Adam (Kingma & Ba 2015, arXiv:1412.6980) moves the targets ahead along the gradient of the differentiable twin
(``agents.twin``), for the largest sd at the end less discomfort. The twin plays the targets of the past again with the
belief's mean, and so knows what they taught. All worlds are planned for together: a plan of one takes as long as one
of fifty.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.planning import Planner
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.device.channels import HIGHEST, LOWEST, N_CHANNELS
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.protocol import Array, Mask

BEGINNING = "refined_one_sided"
"""The maneuver from which the first search goes."""
KNOT_S = 0.4
SCALE = np.array([0.25, 0.4, 0.1, 0.4])
"""Of the channels' steps."""
LEARNING_RATE = 0.03  # of Adam, in parts of ``SCALE``
PRICE = 8.0  # nats that a second of the twin's discomfort is worth


class GradientPlanner(Planner):
    """It goes down the twin's gradient.

    Args:
        name: its name.
        first: steps of Adam before the episode; a clairvoyant one, which then knows all, makes three times as many.
        again: steps of Adam in each later plan.
        **arguments: of ``Planner``.

    Raises:
        InputError: another control mode than targets.
    """

    together = 50

    def __init__(
        self,
        name: str,
        *,
        first: int = 20,
        again: int = 3,
        clairvoyant: bool = False,
        control: Control = DEFAULT_CONTROL,
    ) -> None:
        self.first, self.again = (3 * first, 0) if clairvoyant else (first, again)
        text = "Moves the targets ahead along the gradient of the differentiable twin, every second anew."
        super().__init__(name, text, clairvoyant=clairvoyant, control=control)

    def _begin(self, simulation: Any) -> None:
        from agents.twin.constants import Twin

        self._twin = Twin(simulation)
        times = np.arange(1, self._planned.shape[1] + 1) / self._hz
        knots = np.arange(0.0, times[-1] + KNOT_S, KNOT_S)
        self._between = np.clip(1.0 - np.abs(times[:, None] - knots) / KNOT_S, 0.0, None)
        self._base: Array = Maneuver.named(BEGINNING).targets(times).value
        self._offsets = np.zeros((len(self._planned), len(knots), N_CHANNELS))

    def _search(self, step: Array, due: Mask) -> None:
        for now in np.unique(step[due]):
            chosen = np.flatnonzero(due & (step == now))
            if now == 0:
                self._planned[chosen], self._offsets[chosen] = self._base, 0.0
            updates = self.again if now else self.first
            if updates:
                self._descend(chosen, int(now), updates)

    def _descend(self, chosen: NDArray[np.intp], now: int, updates: int) -> None:
        """Plan what some worlds do from a step on."""
        import torch

        from agents.twin.objective import log_worst
        from agents.twin.worlds import Worlds

        patients = self._patients(chosen)
        played = torch.tensor(self._planned[chosen, :now])
        base, between = torch.tensor(self._base[now:]), torch.tensor(self._between[now:])
        x = torch.tensor(self._offsets[chosen], requires_grad=True)
        optimiser = torch.optim.Adam([x], LEARNING_RATE, betas=(0.8, 0.95))
        scale = torch.tensor(SCALE)
        for _ in range(updates):
            worlds = Worlds(self._twin, patients)
            with torch.no_grad():
                for target in played.unbind(1):
                    worlds.step(target)
            discomfort = x.new_zeros(len(chosen))
            for target in (base + between @ (x * scale)).unbind(1):
                discomfort = discomfort + worlds.step(target)
            optimiser.zero_grad()
            (log_worst(worlds) + PRICE * discomfort).sum().backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        found = (base + between @ (x.detach() * scale)).numpy()
        self._planned[chosen, now:] = np.clip(found, np.array(LOWEST), HIGHEST)
        self._offsets[chosen] = x.detach().numpy()

    def _patients(self, chosen: NDArray[np.intp]) -> Any:
        """The patients of some worlds, as they are believed to be."""
        import torch

        from agents.twin.constants import Patients

        worlds = self._simulation.worlds[chosen]
        patients = Patients.of_worlds(worlds)
        if self.clairvoyant:
            return patients
        return replace(patients, theta=torch.tensor(worlds["known"]["belief"]["mean"]))
