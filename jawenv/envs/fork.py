"""Copies of worlds that are played ahead, as a planner does it, while the worlds stay as they are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.envs.world.plants import take_body
from jawenv.mechanics.dynamics import N_BODY, N_STATES

QUIET = 1e-3
"""Share of the noise in the copies. Not 0, since the filter leaves a reading out that repeats the last to the bit."""
_NOISE = (
    "unmodelled_force",
    "unmodelled_moment",
    "cell_force",
    "cell_moment",
    "encoder_position",
    "encoder_angle",
    "encoder_velocity",
    "encoder_rate",
)


class Fork:
    """K copies of each of N worlds; copies of one world stand beside each other. ``Simulation.fork`` makes it.

    A copy has the world's device and filter: belief, motors, targets, comfort limits, last reading, tick. Its noise is
    a thousandth of the device's, while the filter counts with all of it: the predicted covariance is that of the
    expected motion. The filter does not filter its readings again in a copy, as it does where its mean has moved far.

    Args:
        simulation: the N worlds, of a ``Simulation``; they are only read.
        copies: K.
        reward: what the copies' steps are paid for.
        believed: whether a copy's truth is what the filter believes (certainty equivalence): muscles, nuisances and
            disturbance at the belief's mean, the filtered motion, the filter's own geometry, no effect that the filter
            does not know; otherwise it is the world's own.
    """

    def __init__(self, simulation: Any, copies: int, *, reward: Any, believed: bool) -> None:
        if simulation.configuration.plant is not None:
            raise InputError("plant is the user's own; allowed for a planner: the environment's")
        if simulation.moved is not None:
            raise InputError(f"model is {simulation.model.name!r}; allowed for a planner: one without pymunk")
        if simulation.own_estimators is not None:
            raise InputError("estimator is the user's own; allowed for a planner: the environment's filter")
        self._real, self._number, self._believed = simulation, copies, believed
        changes: dict[str, Any] = {"reality": None} if believed else {}
        # Copies never begin an episode: that of the shortest length keeps the fewest readings.
        period = 1.0 / simulation.configuration.steps_per_s
        changes |= {"record": False, "track_bound": False, "reward": reward, "episode_s": period}
        number = copies * len(simulation.worlds)
        self._copies = type(simulation)(number, replace(simulation.configuration, **changes))
        self._copies.ticks = np.zeros((number, 1), dtype=simulation.ticks.dtype)
        for name in _NOISE:
            self._copies.device[name] *= QUIET

    @property
    def worlds(self) -> NDArray[np.void]:
        """(N K) records, as ``Simulation.worlds``."""
        worlds: NDArray[np.void] = self._copies.worlds
        return worlds

    @property
    def asked(self) -> NDArray[np.bool_]:
        """(N K, M), as ``Simulation.asked``."""
        asked: NDArray[np.bool_] = self._copies.asked
        return asked

    def begin(self, keys: NDArray[np.uint64]) -> None:
        """Put all copies where the worlds are now.

        Args:
            keys: (N, 2) of the noise, the same for all copies of a world, so that only their actions differ.
        """
        worlds = self._real.worlds.copy()
        if self._believed:
            believe(worlds, self._real)
        worlds["truth"]["key"] = keys
        self._copies.worlds[:] = np.repeat(worlds, self._number)
        self._copies.models[:] = np.repeat(self._real.models, self._number)
        self._copies.asked[:] = np.repeat(self._real.asked, self._number, axis=0)

    def advance(self, actions: NDArray[np.float64], chosen: NDArray[np.bool_]) -> None:
        """Play a control period with actions (N K, 4) in the copies of chosen worlds (N,)."""
        self._copies.advance(actions, np.repeat(chosen, self._number))


def believe(worlds: NDArray[np.void], simulation: Any) -> None:
    """Make what the filter believes of copies of the N worlds of a simulation their truth."""
    truth, belief, models = worlds["truth"], worlds["known"]["belief"], simulation.models
    nuisances, changes = belief["nuisances"], simulation.settings["filter"]["nuisances"]
    truth["jaw"] = belief["jaw"] if nuisances.size else models
    truth["cell_offset"] = nuisances @ changes["offset"]
    truth["turn"], truth["cell_turn"] = nuisances @ changes["turn"], nuisances @ changes["cell_turn"]
    truth["log_parameters"] = belief["mean"]
    of_line = 2 * models["muscle"].astype(np.intp)
    for k in range(2):
        truth["muscles"][..., k] = np.exp(np.take_along_axis(belief["mean"], of_line + k, axis=1))
    truth["cell_gain"] = 0.0
    truth["lift"] = 0.0
    states = N_BODY if np.all(models["condyles"] == 2) else N_STATES
    disturbance = belief["motion"][:, states:]  # none where it has no memory
    truth["unmodelled"] = disturbance if disturbance.size else 0.0
    if states == N_BODY:
        truth["body"] = belief["motion"][:, :N_BODY]
        for i in range(len(worlds)):
            take_body(truth[i])
    else:
        truth["state"] = belief["motion"][:, :N_STATES]
