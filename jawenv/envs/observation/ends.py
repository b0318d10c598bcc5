"""The parts of an observation that not every environment has: question, spent budget, correlations."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.envs.observation import OBSERVATION_BOUND, observation_layout


def show_ends(simulation: Any, chosen: NDArray[np.bool_]) -> None:
    """Fill them in the observations of the chosen worlds (N,) of a ``Simulation``."""
    configuration, rows = simulation.configuration, simulation.observation
    muscles, known = simulation.asked.shape[1], simulation.worlds["known"]
    layout = observation_layout(2 * muscles, *configuration.ends)
    if configuration.asked is not None:
        discomfort = simulation.cost_so_far[chosen, None] / configuration.steps_per_s
        rows[chosen, layout["asked"]] = simulation.asked[chosen]
        rows[chosen, layout["discomfort"]] = np.minimum(discomfort, OBSERVATION_BOUND)
    elif configuration.comfort_budget_s is not None:
        spent = known["tracker"]["budget"]["spent"][chosen, None] / configuration.comfort_budget_s
        rows[chosen, layout["spent"]] = np.minimum(spent, OBSERVATION_BOUND)
    if configuration.observe_correlations:
        covariance = known["belief"]["cov"][chosen, : 2 * muscles, : 2 * muscles]
        rows[chosen, layout["correlations"]] = _correlations(covariance)


def _correlations(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Correlations (N, p (p - 1) / 2) of covariances (N, p, p), row by row above the diagonal."""
    sd = np.sqrt(np.maximum(covariance.diagonal(axis1=1, axis2=2), 1e-300))
    rows, columns = np.triu_indices(covariance.shape[1], 1)
    shares: NDArray[np.float64] = covariance[:, rows, columns] / (sd[:, rows] * sd[:, columns])
    return shares.clip(-1.0, 1.0)
