"""Forecasts of a planner: copies of the worlds, played ahead by the compiled core."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.envs.rewards import potential
from jawenv.envs.simulation import Simulation
from jawenv.playing.agents import Array, Mask


class Forecast(NamedTuple):
    """Expected results of K sequences of actions in each of N worlds.

    Attributes:
        gain: (N, K) growth of the potential, nats.
        cost: (N, K) discomfort, s.
        lost: (N, K) whether a hard limit is crossed or the belief is no number.
    """

    gain: Array
    cost: Array
    lost: Mask


class Prediction:
    """K copies of each of N worlds (``jawenv.envs.fork``).

    Args:
        simulation: the N worlds; they are only read.
        candidates: K.
        goal: a potential of ``jawenv.envs.rewards``; the prediction is of its growth.
        clairvoyant: copies have the worlds' true muscles, geometry, motion, tissue and sensor errors.

    Raises:
        InputError: worlds that cannot be copied.
    """

    def __init__(self, simulation: Simulation, candidates: int, *, goal: str, clairvoyant: bool) -> None:
        self._real, self._candidates, self._goal = simulation, candidates, goal
        self._fork = simulation.fork(candidates, reward=goal, believed=not clairvoyant)

    def try_out(self, actions: Array, chosen: Mask, keys: NDArray[np.uint64]) -> Forecast:
        """Play sequences of actions from where the worlds are now.

        Args:
            actions: (N, K, H, 4) in [-1, 1], of the H next control periods.
            chosen: (N,) the worlds to predict; rows of the others hold no meaning.
            keys: (N, 2) of the noise, the same for all candidates of a world, so that only their actions differ.
        """
        before = potential(self._goal, self._real)
        self._fork.begin(keys)
        truth, filters = self._fork.worlds["truth"], self._fork.worlds["known"]
        cost = np.zeros(len(self._fork.worlds))
        for step in range(actions.shape[2]):
            flat = np.ascontiguousarray(actions[:, :, step].reshape(-1, actions.shape[3]), dtype=np.float64)
            self._fork.advance(flat, chosen)
            cost += truth["costs"].sum(axis=-1) / self._real.configuration.steps_per_s
        after, shape = potential(self._goal, self._fork), (len(chosen), self._candidates)
        lost = (truth["violated"] != 0) | ~np.isfinite(filters["log_det"]) | ~np.isfinite(cost)
        return Forecast(after.reshape(shape) - before[:, None], cost.reshape(shape), lost.reshape(shape))
