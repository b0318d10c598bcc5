"""What a planner expects of actions: copies of the worlds, played ahead by the compiled core."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.envs.rewards import potential
from jawenv.envs.simulation import Simulation
from jawenv.envs.world.plants import take_body
from jawenv.errors import InputError
from jawenv.mechanics.bilateral import N_BODY
from jawenv.mechanics.dynamics import N_STATES
from jawenv.playing.protocol import Array, Mask

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


class Outcome(NamedTuple):
    """What is expected of K sequences of actions in each of N worlds.

    Attributes:
        gain: (N, K) growth of the potential, nats.
        cost: (N, K) discomfort, s.
        lost: (N, K) whether a hard limit is crossed or the belief is no number.
    """

    gain: Array
    cost: Array
    lost: Mask


class Prediction:
    """K copies of each of N worlds.

    A copy has the world's device and filter: belief, motors, targets, comfort limits, last reading, tick. Its truth is
    what the filter believes (certainty equivalence): muscles, nuisances and disturbance at the belief's mean, the
    filtered motion, the filter's own geometry, no effect that the filter does not know. Its noise is a thousandth of
    the device's, while the filter counts with all of it: the predicted covariance is that of the expected motion. The
    filter does not filter its readings again in a copy, as it does where its mean has moved far.

    Args:
        simulation: the N worlds; they are only read.
        candidates: K.
        goal: the potential of ``jawenv.envs.rewards`` whose growth is predicted.
        clairvoyant: copies have the worlds' true muscles, geometry, motion, tissue and sensor errors instead.

    Raises:
        InputError: worlds that are moved by another physics engine, which cannot be copied, or that show the belief of
            another filter than the device's.
    """

    def __init__(self, simulation: Simulation, candidates: int, *, goal: str, clairvoyant: bool) -> None:
        configuration = simulation.configuration
        if simulation.model.plant == "contact":
            raise InputError(f"model is {simulation.model.name!r}; allowed for a planner: one without pymunk")
        if simulation.own_estimators is not None:
            raise InputError("estimator is the user's own; allowed for a planner: the environment's filter")
        self._real, self._candidates, self._clairvoyant = simulation, candidates, clairvoyant
        self._goal = goal
        changes: dict[str, Any] = {} if clairvoyant else {"reality": None}
        # Copies never begin an episode: that of the shortest length keeps the fewest readings.
        period = 1.0 / configuration.steps_per_s
        changes |= {"record": False, "track_bound": False, "reward": goal, "episode_s": period}
        number = candidates * len(simulation.worlds)
        self._copies = Simulation(number, replace(configuration, **changes))
        self._copies.ticks = np.zeros((number, 1), dtype=simulation.ticks.dtype)
        for name in _NOISE:
            self._copies.device[name] *= QUIET

    def try_out(self, actions: Array, chosen: Mask, keys: NDArray[np.uint64]) -> Outcome:
        """Play sequences of actions from where the worlds are now.

        Args:
            actions: (N, K, H, 4) in [-1, 1], of the H next control periods.
            chosen: (N,) worlds that are looked at; what is said of the others means nothing.
            keys: (N, 2) of the noise, the same for all candidates of a world, so that only their actions differ.
        """
        worlds, candidates = self._real.worlds.copy(), self._candidates
        before = potential(self._goal, worlds)
        if not self._clairvoyant:
            believe(worlds, self._real)
        worlds["truth"]["key"] = keys
        copies = self._copies
        copies.worlds[:] = np.repeat(worlds, candidates)
        truth, known = copies.worlds["truth"], copies.worlds["known"]
        copies.models[:] = np.repeat(self._real.models, candidates)
        active = np.repeat(chosen, candidates)
        cost = np.zeros(len(copies.worlds))
        for step in range(actions.shape[2]):
            flat = np.ascontiguousarray(actions[:, :, step].reshape(-1, actions.shape[3]), dtype=np.float64)
            copies.advance(flat, active)
            cost += truth["costs"].sum(axis=-1) / self._real.configuration.steps_per_s
        after, shape = potential(self._goal, copies.worlds), (len(worlds), candidates)
        lost = (truth["violated"] != 0) | ~np.isfinite(known["log_det"]) | ~np.isfinite(cost)
        return Outcome(after.reshape(shape) - before[:, None], cost.reshape(shape), lost.reshape(shape))


def believe(worlds: NDArray[np.void], simulation: Simulation) -> None:
    """Make what the filter believes of N worlds their truth.

    Args:
        worlds: copies of the N records of ``simulation``; changed.
        simulation: whose filter it is.
    """
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
