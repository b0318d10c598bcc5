"""A planner: an agent that plays candidates ahead from the filter's belief and begins the best of them.

It samples sequences of targets, predicts what each would teach and cost (``agents.prediction``), and plans again after
a second. It is certainty-equivalent: the belief's mean is taken for the truth, so that it does not probe on purpose,
but what it does follows from what was learnt of this patient. A clairvoyant one takes the truth for the truth. It is no
contestant, but a yardstick of what adapting to the patient can be worth.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from agents.prediction import Forecast, Prediction
from jawenv.checks import whole_number
from jawenv.controls import DEFAULT_CONTROL, Control, takes_targets
from jawenv.device.channels import N_CHANNELS
from jawenv.envs.rewards import potential
from jawenv.errors import InputError, shown
from jawenv.playing.agents import BatchAgent
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.player import action_of
from jawenv.playing.protocol import Action, Array, Mask, Observation, State

LOW, HIGH = np.array([0.0, -0.9, -0.3, -0.9]), np.array([0.95, 0.9, 0.3, 0.9])
"""Targets that are sampled lie in this box, fractions of the patient's comfort."""
SPREAD = np.array([0.25, 0.4, 0.1, 0.4])
"""Sd of variations of a sequence, before a search makes them smaller from round to round."""
MOST_CANDIDATES = 10_000  # each is a copy of the world, some 50 kB with its scratch arrays
FORBIDDEN = 1e6  # nats off the score of a candidate that crosses a hard limit


@dataclass(frozen=True)
class Plan:
    """How a planner searches.

    Attributes:
        name: its name.
        description: a sentence on its method.
        horizon_s: how far it looks ahead.
        candidates: sequences that are tried in a round.
        rounds: how often sequences are varied about the best ones.
        elites: how many are the best ones.
        maneuvers: the first round tries their continuations.
        clairvoyant: whether candidates are tried on the true patient.
        replan_s: how long it follows a plan.
        comfort_weight: nats that a second of discomfort is worth.
        goal: potential of the gain; ``"mixed"``, ``"worst"`` or ``"uncertainty"``.
        common: share of the worlds, the least known, with a mean score that decides for all; 0 where each world
            has a plan of its own. So a maneuver is designed for a cohort of worlds in the same step.

    Raises:
        InputError: fewer candidates than elites, or than sequences that are always tried, or too many.
    """

    name: str
    description: str
    horizon_s: float
    candidates: int
    rounds: int = 1
    elites: int = 1
    maneuvers: tuple[str, ...] = ()
    clairvoyant: bool = False
    replan_s: float = 1.0
    comfort_weight: float = 20.0
    goal: str = "mixed"
    common: float = 0.0

    def __post_init__(self) -> None:
        """Check the number of candidates."""
        # To stay, the maneuvers and, after the first plan, the last one are tried first.
        fixed = len(self.maneuvers) + 2 if self.maneuvers else 1
        least, number = max(self.elites, fixed), whole_number(self.candidates)
        if number is None or not least <= number <= MOST_CANDIDATES:
            raise InputError(f"candidates is {shown(self.candidates)}; allowed: {least} to {MOST_CANDIDATES}")


class Planner(BatchAgent):
    """An agent that searches for the next targets in copies of the worlds.

    World i draws from streams seeded by ``seed + i`` and the number of the step, so that its plans do not depend on the
    other worlds.

    Args:
        plan: how it searches.
        control: control mode of the environment.

    Attributes:
        name: name of the plan.
        description: description of the plan.
        decisions: plans made since ``reset``, over all worlds.
        seconds: time that they took in all.
        knot_s: between knots of a variation.

    Raises:
        InputError: another control mode than targets.
    """

    knot_s = 1.0

    def __init__(self, plan: Plan, *, control: Control = DEFAULT_CONTROL) -> None:
        _check_control(plan.name, control)
        self.plan, self.name, self.description = plan, plan.name, plan.description
        self.control = control
        self._maneuvers = [Maneuver.named(name) for name in plan.maneuvers]
        self.reset(0)

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget the worlds; without a seed the plans differ from run to run."""
        self._seed = int(np.random.default_rng().integers(2**31)) if seed is None else seed
        self._env: Any = None
        self.decisions, self.seconds = 0, 0.0

    @property
    def ms_per_decision(self) -> float:
        """Milliseconds that the plan of one world took on average; NaN before the first."""
        return 1e3 * self.seconds / self.decisions if self.decisions else float("nan")

    def attach(self, env: VectorEnv[Any, Any, Any]) -> None:
        """See ``jawenv.playing.protocol.Planning.attach``.

        Raises:
            InputError: an environment with another control mode than targets, or one that cannot be copied.
        """
        self._env = env.unwrapped
        simulation = self._env.simulation
        configuration = simulation.configuration
        _check_control(self.name, configuration.control)
        self._hz = configuration.steps_per_s
        self._horizon = max(1, round(self.plan.horizon_s * self._hz))
        self._follow = min(self._horizon, max(1, round(self.plan.replan_s * self._hz)))
        self._prediction = Prediction(
            simulation, self.plan.candidates, goal=self.plan.goal, clairvoyant=self.plan.clairvoyant
        )
        number = len(simulation.worlds)
        self._planned = np.zeros((number, self._horizon, N_CHANNELS))
        self._planned_at = np.full(number, -1)

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        # Only the attached environment is read; the observations give the number of worlds.
        if self._env is None:
            raise InputError(f"agent {self.name!r}: no environment; allowed: attach(env) before predict, as play does")
        worlds = self._env.simulation.worlds
        if len(rows) != len(worlds):
            raise InputError(f"observation has {len(rows)} worlds; allowed: the {len(worlds)} of the environment")
        configuration = self._env.configuration
        filters, violated = worlds["known"], worlds["truth"]["violated"]
        step = (filters["tick"] // configuration.ticks_per_step).astype(np.intp)
        running = (step < configuration.steps) & (violated == 0) & np.isfinite(filters["log_det"])
        since = step - self._planned_at
        due = running & ((self._planned_at < 0) | (since < 0) | (since >= self._follow) | (step == 0))
        if due.any():
            began = time.perf_counter()
            self._search(step, due)
            self.decisions, self.seconds = self.decisions + int(due.sum()), self.seconds + time.perf_counter() - began
        index = np.clip(step - self._planned_at, 0, self._horizon - 1)
        return action_of(self._planned[np.arange(len(rows)), index]).astype(np.float32), None

    def _search(self, step: Array, due: Mask) -> None:
        """Plan anew for the worlds that are due."""
        number, plan = len(due), self.plan
        streams, keys = self._chance(step)
        tried = np.zeros((number, plan.candidates, self._horizon, N_CHANNELS))
        best, best_score = self._planned.copy(), np.full(number, -np.inf)
        for i in np.flatnonzero(due):
            tried[i] = self._first(int(i), int(step[i]), streams[i])
        for size in 0.5 ** np.arange(1, plan.rounds + 1):
            score = self._judge(tried, due, keys)
            for i in np.flatnonzero(due):
                order = np.argsort(-score[i], kind="stable")
                if score[i, order[0]] > best_score[i]:
                    best[i], best_score[i] = tried[i, order[0]], score[i, order[0]]
                elites = tried[i, order[: plan.elites]]
                tried[i] = self._vary(elites, plan.candidates, size, streams[i])
        self._planned[due] = best[due]
        self._planned_at[due] = step[due]

    def _chance(self, step: Array) -> tuple[list[np.random.Generator], NDArray[np.uint64]]:
        """A stream of random numbers for each world's candidates, and the (N, 2) keys of the noise in its copies."""
        own = np.zeros(len(step), dtype=int) if self.plan.common else np.arange(len(step))
        streams = [np.random.default_rng([self._seed + int(i), int(k)]) for i, k in zip(own, step, strict=True)]
        return streams, np.array([stream.integers(0, 2**63, size=2, dtype=np.uint64) for stream in streams])

    def _judge(self, tried: Array, due: Mask, keys: NDArray[np.uint64]) -> Array:
        """Scores (N, K) of the candidates (N, K, H, 4), nats."""
        score = _score(self._prediction.try_out(action_of(tried), due, keys), self.plan.comfort_weight)
        if self.plan.common:
            score[:] = score[self._least_known(due)].mean(axis=0)
        return score

    def _least_known(self, due: Mask) -> NDArray[np.intp]:
        """Indices of the worlds with a say in the common plan."""
        level = np.where(due, potential(self.plan.goal, self._env.simulation), np.inf)
        return np.argsort(level, kind="stable")[: max(1, round(self.plan.common * int(due.sum())))]

    def _first(self, world: int, step: int, stream: np.random.Generator) -> Array:
        """Candidates (K, H, 4) of the first round: good starts, their variations, and random ones."""
        start = self._env.simulation.targets[world]
        tried = [np.broadcast_to(start, (self._horizon, N_CHANNELS))]
        tried += self._continued(start, step)
        if self._maneuvers and 0 <= self._planned_at[world] < step:
            left = np.minimum(np.arange(self._horizon) + step - self._planned_at[world], self._horizon - 1)
            tried.append(self._planned[world, left])
        rest = self.plan.candidates - len(tried)
        varied = self._vary(np.array(tried), rest // 2 if self._maneuvers else 0, 1.0, stream)
        goals = stream.uniform(LOW, HIGH, (rest - len(varied), len(self._knots), N_CHANNELS))
        anywhere = start + np.einsum("hk,ckj->chj", self._between, goals - start)
        return np.concatenate([tried, varied, anywhere])

    def _continued(self, start: Array, step: int) -> list[Array]:
        """Each maneuver from a step on (H, 4), reached from the targets ``start`` (4) within a second."""
        ahead = np.arange(1, self._horizon + 1) / self._hz
        return [approach(start, maneuver.targets(step / self._hz + ahead).value, ahead) for maneuver in self._maneuvers]

    def _vary(self, sequences: Array, number: int, size: float, stream: np.random.Generator) -> Array:
        """Variations (number, H, 4) of sequences (E, H, 4), each in turn, none of them at the start."""
        noise = size * SPREAD * stream.standard_normal((number, len(self._knots), N_CHANNELS))
        shifted = sequences[np.arange(number) % len(sequences)] + np.einsum("hk,ckj->chj", self._between, noise)
        within: Array = np.clip(shifted, LOW, HIGH)
        return within

    @property
    def _knots(self) -> Array:
        """(knots,) s after the start of a plan; the last is at its end."""
        number = max(1, round(self._horizon / self._hz / self.knot_s))
        return np.linspace(0.0, self._horizon / self._hz, number + 1)[1:]

    @property
    def _between(self) -> Array:
        """(H, knots) straight lines from 0 at the start through the values at the knots."""
        ahead, times = np.arange(1, self._horizon + 1) / self._hz, np.append(0.0, self._knots)
        unit = np.eye(len(times))[1:]
        return np.stack([np.interp(ahead, times, row) for row in unit], axis=-1)


def approach(start: Array, targets: Array, ahead: Array) -> Array:
    """Targets (H, 4) ``ahead`` s, reached from ``start`` (4) within a second."""
    share = np.minimum(ahead, 1.0)[:, None]
    return start + share * (targets - start)


def _score(forecast: Forecast, comfort_weight: float) -> Array:
    """Scores (N, K) of forecasts, nats."""
    worth = forecast.gain - comfort_weight * forecast.cost
    return np.where(forecast.lost, -FORBIDDEN, worth)


def _check_control(name: str, control: object) -> None:
    if not takes_targets(control):
        raise InputError(f"agent {name!r}: control is {shown(control)}; allowed: targets")
