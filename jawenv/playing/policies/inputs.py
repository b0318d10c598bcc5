"""A policy's view of an observation: the parts that it knows, and the belief as it learned to read it.

An observation says where a belief stands beside the prior. A policy that plays with another prior than it was trained
with, of another cohort or of an earlier treatment, is shown the same belief beside its own prior.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.anatomy.prior import Prior
from jawenv.base.errors import InputError
from jawenv.envs.observation import OBSERVATION_BOUND, Parts
from jawenv.playing.agents import Observation


class OwnParts:
    """Observations as a policy knows them: the parts that it knows, by name, with nothing spent of no budget.

    Args:
        parts: that the policy was trained with; those of the worlds that it plays, until it is told.
        policy: whom messages name.
    """

    def __init__(self, parts: Parts, policy: object) -> None:
        self._own = self._played = parts
        self._policy = policy

    def take(self, played: Parts) -> None:
        """Take the parts of the worlds that are to be played.

        Raises:
            InputError: another model, or without a part that the policy reads.
        """
        lacking = [name for name in self._own.layout if name not in played.layout and name != "spent"]
        if lacking or played.n_parameters != self._own.n_parameters:
            why = f"no {' and '.join(lacking)}" if lacking else f"{played.n_parameters} parameters"
            allowed = f"{', '.join(self._own.layout)} of {self._own.n_parameters} parameters"
            raise InputError(f"{self._policy}: the environment's observation has {why}; allowed: {allowed}")
        self._played = played

    def __call__(self, rows: Observation) -> Observation:
        """Observations (N, size) as the policy knows them, (N, its own size)."""
        self._played.check(rows.shape[1], self._policy)
        if self._played == self._own:
            return rows
        seen = np.zeros((len(rows), self._own.size), dtype=rows.dtype)
        played, own = self._played.layout, self._own.layout
        for name in played.keys() & own.keys():
            seen[:, own[name]] = rows[:, played[name]]
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
