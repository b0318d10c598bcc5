"""A policy's view of an observation: the parts that it knows, and the belief as it learned to read it.

An observation says where a belief stands beside the prior. A policy that plays with another prior than it was trained
with, of another cohort or of an earlier treatment, is shown the same belief beside its own prior.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.anatomy.prior import Prior
from jawenv.base.errors import InputError
from jawenv.envs.observation import OBSERVATION_BOUND, layouts, observation_layout
from jawenv.playing.agents import Observation


def fitted(rows: Observation, size: int, policy: object) -> Observation:
    """Observations (N, size) as a policy knows them: the parts that it knows, with nothing spent of no budget.

    Raises:
        InputError: an observation of another model, or one without the question or correlations that the policy reads.
    """
    if rows.shape[1] == size:
        return rows
    given, known = layouts().get(rows.shape[1]), layouts().get(size)
    if given is None or known is None or given[0] != known[0] or any(known[i] and not given[i] for i in (1, 3)):
        why = "is it another model, or is `asked` or `observe_correlations` missing?"
        raise InputError(f"{policy}: trained on observations of {size} values, got {rows.shape[1]}; {why}")
    seen = np.zeros((len(rows), size), dtype=rows.dtype)
    parts, wanted = observation_layout(*given), observation_layout(*known)
    for name in parts.keys() & wanted.keys():
        seen[:, wanted[name]] = rows[:, parts[name]]
    return seen


class OwnPrior:
    """Beliefs beside the prior of an environment as beliefs beside a policy's own.

    Args:
        prior: that the policy was trained with.
    """

    def __init__(self, prior: Prior) -> None:
        self._prior = prior
        self._factor: Observation | None = None

    def take(self, played: Prior) -> None:
        """Take the prior of the worlds that are to be played."""
        own = self._prior
        self._factor = None
        if own.mean.shape != played.mean.shape or (_same(own.mean, played.mean) and _same(own.sd, played.sd)):
            return
        self._factor = np.concatenate([played.sd / own.sd, np.ones_like(own.sd)]).astype(np.float32)
        beside = (played.mean - own.mean) / own.sd, np.log10(played.sd / own.sd)
        self._beside = np.concatenate(beside).astype(np.float32)

    def __call__(self, rows: Observation) -> Observation:
        """The same observations (N, size) with another belief."""
        if self._factor is None:
            return rows
        rows, belief = rows.copy(), len(self._factor)
        moved = rows[:, :belief] * self._factor + self._beside
        rows[:, :belief] = np.clip(moved, -OBSERVATION_BOUND, OBSERVATION_BOUND)
        return rows


def _same(a: Any, b: Any) -> bool:
    return bool(np.array_equal(a, b))
