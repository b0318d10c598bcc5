"""Rewards: each is the increment of a potential, so an episode's sum (gamma = 1) is what the potential has grown.

No information is paid for twice: what a re-inflating covariance takes from the potential is taken from the reward.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

NORM = 6.0  # of the sds: near to the largest, and still smooth


class _Worlds(Protocol):
    """N worlds, of a ``Simulation``."""

    @property
    def worlds(self) -> NDArray[np.void]:
        """(N,) records."""

    @property
    def asked(self) -> NDArray[np.bool_]:
        """(N, M) the muscles that are asked for."""


def claimed_information(worlds: NDArray[np.void]) -> Any:
    """Half the fall of the log-determinant (N,) since the prior, nats."""
    return 0.5 * (worlds["known"]["log_det_prior"] - worlds["known"]["log_det"])


def _bound_information(simulation: _Worlds) -> Any:
    worlds = simulation.worlds
    return 0.5 * (worlds["known"]["log_det_prior"] - worlds["truth"]["log_det_bound"])


def _score(simulation: _Worlds) -> Any:
    truth = simulation.worlds["truth"]
    return truth["log_score"] - truth["log_score_prior"]


def _worst_sd_potential(simulation: _Worlds) -> Any:
    variances = np.diagonal(simulation.worlds["known"]["belief"]["cov"], axis1=-2, axis2=-1)
    asked = np.repeat(simulation.asked, 2, axis=-1)
    number = asked.sum(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        norm = np.log(np.sum(asked * variances ** (0.5 * NORM), axis=-1) / number) / NORM
    return -number * norm


def _mixed(simulation: _Worlds) -> Any:
    return 0.5 * (claimed_information(simulation.worlds) + _worst_sd_potential(simulation))


POTENTIALS: Mapping[str, Callable[[_Worlds], Any]] = MappingProxyType(
    {
        "uncertainty": lambda simulation: claimed_information(simulation.worlds),
        "bound": _bound_information,
        "score": _score,
        "worst": _worst_sd_potential,
        "mixed": _mixed,
    }
)
"""The potential (N,) of each reward, nats. The argument ``reward`` takes their names.

``"uncertainty"``: half the fall of the log-determinant that the filter claims. ``"bound"``: the same for the posterior
Cramer-Rao bound at the truth. ``"score"``: log posterior less log prior density at the truth. ``"worst"``: minus the
number of parameters times the logarithm of the mean 6-norm of the sds, which is nearly the largest sd's; it grows as
``"uncertainty"`` does where all sds, uncorrelated, fall alike. Parameters are those of the muscles that are asked for.
``"mixed"``: the mean of ``"uncertainty"`` and ``"worst"``.
"""


def potential(reward: str, simulation: _Worlds) -> NDArray[np.float64]:
    """The potential (N,) of a reward, which pays its increments, nats; 0 where the belief makes it infinite or NaN."""
    nats = POTENTIALS[reward](simulation)
    finite: NDArray[np.float64] = np.where(np.isfinite(nats), nats, 0.0)
    return finite
