"""Rewards: each is the increment of a potential, so an episode's sum (gamma = 1) is what the potential has grown.

No information is paid for twice: what a re-inflating covariance takes from the potential is taken from the reward.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

NORM = 6.0  # of the sds: near to the largest, and still smooth


def potential(reward: str, worlds: NDArray[np.void]) -> NDArray[np.float64]:
    """The potential (N,) of a reward, which pays its increments, in nats; 0 for a belief that is not a number.

    ``"uncertainty"``: half the fall of the log-determinant that the filter claims. ``"bound"``: the same for the
    posterior Cramer-Rao bound at the truth. ``"score"``: log posterior less log prior density at the truth.
    ``"worst"``: minus the number of parameters times the logarithm of the mean 6-norm of the sds, which is nearly the
    largest sd's; it grows as ``"uncertainty"`` does where all sds, uncorrelated, fall alike. ``"mixed"``: the mean of
    ``"uncertainty"`` and ``"worst"``.
    """
    nats: Any
    if reward == "bound":
        nats = 0.5 * (worlds["known"]["log_det_prior"] - worlds["truth"]["log_det_bound"])
    elif reward == "score":
        nats = worlds["truth"]["log_score"] - worlds["truth"]["log_score_prior"]
    elif reward == "uncertainty":
        nats = claimed_information(worlds)
    elif reward == "worst":
        nats = worst_sd_potential(worlds)
    else:
        nats = 0.5 * (claimed_information(worlds) + worst_sd_potential(worlds))
    finite: NDArray[np.float64] = np.where(np.isfinite(nats), nats, 0.0)
    return finite


def claimed_information(worlds: NDArray[np.void]) -> Any:
    """Half the fall of the log-determinant (N,) since the prior, nats."""
    return 0.5 * (worlds["known"]["log_det_prior"] - worlds["known"]["log_det"])


def worst_sd_potential(worlds: NDArray[np.void]) -> Any:
    """The potential (N,) of ``"worst"``, nats."""
    variances = np.diagonal(worlds["known"]["belief"]["cov"], axis1=-2, axis2=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        norm = np.log(np.mean(variances ** (0.5 * NORM), axis=-1)) / NORM
    return -variances.shape[-1] * norm
