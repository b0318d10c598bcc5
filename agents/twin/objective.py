"""Objective that the twin's gradient makes small."""

from __future__ import annotations

from math import log

from torch import Tensor

from agents.twin.worlds import Worlds

POWER = 10.0
MARKS = ((0.36, 0.2), (0.64, 0.2), (1.0, 0.6))
"""Shares of a maneuver's time at which the largest sd counts, and how much."""
_SURE, _SOFTNESS = 0.05, 0.2
"""Error bar from which on a patient's muscles count as known, and the width of the step, nats."""


def log_worst(worlds: Worlds) -> Tensor:
    """Smooth log (P,) of the largest sd of the parameters that are asked for: that of their 10-norm."""
    variances = worlds.belief.covariance.diagonal(dim1=-2, dim2=-1)[:, :12]
    asked = worlds.asked.repeat_interleave(2, -1)
    log: Tensor = (asked * variances.pow(POWER / 2.0)).sum(-1).log() / POWER
    return log


def weights(steps: int) -> dict[int, float]:
    """Decision -> weight of ``log_worst`` after it, in a maneuver of so many."""
    return {max(1, round(share * steps)): weight for share, weight in MARKS}


def share_unsure(worlds: Worlds) -> Tensor:
    """Smooth step (P,): 1 while the largest sd of what is asked for is above ``_SURE``, 0 below."""
    step: Tensor = ((log_worst(worlds) - log(_SURE)) / _SOFTNESS).sigmoid()
    return step
