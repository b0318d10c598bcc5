"""The controls that choose a patient and a model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from jawenv.anatomy import COHORTS
from jawenv.anatomy.knowledge import LEVELS
from jawenv.controls import CONTROLS
from jawenv.ladder import MODELS
from jawenv.live.setup import LONGEST_S, SHORTEST_S, Setup
from jawenv.playing.rollout import LARGEST_SEED

_LARGEST_BUDGET_S = 100.0


class Choices:
    """Choices of a patient and of a model; ``setup`` is what they say.

    Args:
        gui: of a ``viser.ViserServer``.
        setup: of the first session.
        leave: makes a callback of viser's that hands a wish to the page.
        change: called when another setup is chosen.
    """

    def __init__(
        self, gui: Any, setup: Setup, leave: Callable[[Callable[[], None]], Any], change: Callable[[], None]
    ) -> None:
        self._world, self._change = setup.world, change
        cohort, knowledge = setup.world.build_cohort(), setup.world.build_knowledge()
        self._cohorts = {**COHORTS, cohort.name: cohort}
        known = next((name for name, level in LEVELS.items() if level == knowledge), "as given")
        self._knowledge = {**LEVELS, known: knowledge}
        with gui.add_folder("Patient and model", expand_by_default=False):
            self.fields = {
                "seed": gui.add_number("Patient seed", setup.seed, min=0, max=LARGEST_SEED, step=1),
                "cohort": gui.add_dropdown("Cohort", tuple(self._cohorts), initial_value=cohort.name),
                "model": gui.add_dropdown("Model", tuple(MODELS), initial_value=setup.world.model),
                "control": gui.add_dropdown("Control", tuple(CONTROLS), initial_value=setup.world.control),
                "knowledge": gui.add_dropdown("Knowledge", tuple(self._knowledge), initial_value=known),
                "episode_s": gui.add_number(
                    "Episode, s", setup.world.episode_s, min=SHORTEST_S, max=LONGEST_S, step=0.5
                ),
                "comfort_budget_s": gui.add_number(
                    "Budget, s",
                    setup.world.comfort_budget_s or 0.0,
                    min=0.0,
                    max=_LARGEST_BUDGET_S,
                    step=0.001,
                    hint="Discomfort that the device keeps in targets control; 0 for none",
                ),
            }
            gui.add_button("New episode").on_click(leave(change))

    def setup(self) -> Setup:
        """The chosen setup."""
        values = {name: field.value for name, field in self.fields.items()}
        seed = int(values.pop("seed"))
        values["comfort_budget_s"] = values["comfort_budget_s"] or None
        patient = {"cohort": self._cohorts[values["cohort"]], "knowledge": self._knowledge[values["knowledge"]]}
        return Setup(replace(self._world, **(values | patient)), seed)

    def next_patient(self) -> None:
        """The patient of the next seed."""
        self.fields["seed"].value = (int(self.fields["seed"].value) + 1) % (LARGEST_SEED + 1)
        self._change()
