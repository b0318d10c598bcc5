"""A planner for every model of the jaw: it plays random targets ahead in copies of the worlds and begins the best."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from agents.planning import Planner
from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import whole_number
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.device.channels import N_CHANNELS
from jawenv.envs.rewards import potential
from jawenv.envs.simulation import Simulation
from jawenv.playing.agents import Array, Mask
from jawenv.playing.maneuvers.maneuver import action_of

LOW, HIGH = np.array([0.0, -0.9, -0.3, -0.9]), np.array([0.95, 0.9, 0.3, 0.9])
"""Targets that are sampled lie in this box, fractions of the patient's comfort."""
HORIZON_S = 1.0
COMFORT_WEIGHT = 20.0  # nats that a second of discomfort is worth
GOAL = "mixed"  # potential of the gain
MOST_CANDIDATES = 10_000  # each is a copy of the world, some 50 kB with its scratch arrays
FORBIDDEN = 1e6  # nats off the score of a candidate that crosses a hard limit


class SamplingPlanner(Planner):
    """It samples targets for the next second and predicts what each would teach and cost.

    World i draws from streams seeded by ``seed + i`` and the number of the step, so that its plans do not depend on the
    other worlds.

    Args:
        name: its name.
        candidates: targets that are tried, to stay first.
        **arguments: of ``Planner``.
    """

    together = 4

    def __init__(
        self, name: str, *, candidates: int = 64, clairvoyant: bool = False, control: Control = DEFAULT_CONTROL
    ) -> None:
        number = whole_number(candidates)
        if number is None or not 1 <= number <= MOST_CANDIDATES:
            raise InputError(f"candidates is {shown(candidates)}; allowed: 1 to {MOST_CANDIDATES}")
        self.candidates = number
        text = "Of sampled targets for the next second, the one of the largest predicted gain less discomfort."
        super().__init__(name, text, clairvoyant=clairvoyant, control=control)

    def _begin(self, simulation: Any) -> None:
        self._horizon = max(1, round(HORIZON_S * self._hz))
        self._prediction = Prediction(simulation, self.candidates, goal=GOAL, clairvoyant=self.clairvoyant)

    def _search(self, step: Array, due: Mask) -> None:
        streams = [np.random.default_rng([self._seed + i, int(k)]) for i, k in enumerate(step)]
        keys = np.array([stream.integers(0, 2**63, size=2, dtype=np.uint64) for stream in streams])
        tried = np.zeros((len(due), self.candidates, self._horizon, N_CHANNELS))
        share = (np.arange(1, self._horizon + 1) / self._horizon)[:, None]
        for i in np.flatnonzero(due):
            start = self._simulation.targets[i]
            goals = streams[i].uniform(LOW, HIGH, (self.candidates, 1, N_CHANNELS))
            goals[0] = start
            tried[i] = start + share * (goals - start)
        forecast = self._prediction.try_out(action_of(tried), due, keys)
        score = np.where(forecast.lost, -FORBIDDEN, forecast.gain - COMFORT_WEIGHT * forecast.cost)
        for i in np.flatnonzero(due):
            ahead = self._planned[i, step[i] : step[i] + self._horizon]
            ahead[:] = tried[i, np.argmax(score[i]), : len(ahead)]


class _Forecast(NamedTuple):
    """Expected results of K sequences of actions in each of N worlds."""

    gain: Array  # (N, K) growth of the potential, nats
    cost: Array  # (N, K) discomfort, s
    lost: Mask  # (N, K) whether a hard limit is crossed or the belief is no number


class Prediction:
    """K copies of each of N worlds (``jawenv.envs.fork``).

    Args:
        simulation: the N worlds; they are only read.
        candidates: K.
        goal: a potential of ``jawenv.envs.rewards``; the prediction is of its growth.
        clairvoyant: copies have the worlds' true muscles, geometry, motion, tissue and sensor errors.
    """

    def __init__(self, simulation: Simulation, candidates: int, *, goal: str, clairvoyant: bool) -> None:
        self._real, self._candidates, self._goal = simulation, candidates, goal
        self._fork = simulation.fork(candidates, reward=goal, believed=not clairvoyant)

    def try_out(self, actions: Array, chosen: Mask, keys: NDArray[np.uint64]) -> _Forecast:
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
        return _Forecast(after.reshape(shape) - before[:, None], cost.reshape(shape), lost.reshape(shape))
