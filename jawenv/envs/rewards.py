"""Rewards: each is the increment of a potential, so an episode's sum (gamma = 1) is its final information in nats.

No information is paid for twice: what a re-inflating covariance takes from the potential is taken from the reward.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def potential(reward: str, worlds: NDArray[np.void]) -> NDArray[np.float64]:
    """Information (N,) in nats since the prior, as ``reward`` counts it; 0 for a belief that is not a number.

    ``"uncertainty"``: half the fall of the log-determinant that the filter claims. ``"bound"``: the same for the
    posterior Cramer-Rao bound at the truth. ``"score"``: log posterior less log prior density at the truth.
    """
    nats: Any
    if reward == "uncertainty":
        nats = 0.5 * (worlds["log_det_prior"] - worlds["log_det"])
    elif reward == "bound":
        nats = 0.5 * (worlds["log_det_prior"] - worlds["log_det_bound"])
    else:
        nats = worlds["log_score"] - worlds["log_score_prior"]
    finite: NDArray[np.float64] = np.where(np.isfinite(nats), nats, 0.0)
    return finite
