"""The parts of an observation that not every environment has: question, spent budget."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.envs.observation import OBSERVATION_BOUND


def fill_optional_parts(simulation: Any, chosen: NDArray[np.bool_]) -> None:
    """Fill them in the observations of the chosen worlds (N,) of a ``Simulation``."""
    configuration, rows = simulation.configuration, simulation.observation
    layout = configuration.parts.layout
    if configuration.asked is not None:
        discomfort = simulation.cost_so_far[chosen, None] / configuration.steps_per_s
        rows[chosen, layout["asked"]] = simulation.asked[chosen]
        rows[chosen, layout["discomfort"]] = np.minimum(discomfort, OBSERVATION_BOUND)
    elif configuration.comfort_budget_s is not None:
        budget = simulation.worlds["known"]["tracker"]["budget"]
        spent = budget["spent"][chosen, None] / configuration.comfort_budget_s
        rows[chosen, layout["spent"]] = np.minimum(spent, OBSERVATION_BOUND)
