"""A maneuver designed second by second: each plan is the one after which a cohort's patients are known best.

Receding-horizon optimal experiment design (the one-step form is in Goodwin & Payne 1977, chapter 6): drawn patients are
moved at once, all by the same targets, and each second the planner of ``agents.planning`` searches how they go on, by
the mean score of the patients. It is quick, greedy, and free of any waveform. What follows the last second is the way
back to rest, and all again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from agents.planning import Plan, Planner
from agents.replay import maneuver_of_targets, targets_of
from jawenv.envs.configuration import configure
from jawenv.errors import InputError
from jawenv.maneuvers import Maneuver
from jawenv.protocol import Action, Mask, Observation, State
from jawenv.rollout import play
from jawenv.seeds import TUNING
from training.search_settings import SearchSettings

Goal = Literal["mixed", "worst", "uncertainty"]
Over = Literal["mean", "tail"]

SHARE = {"mean": 1.0, "tail": 1.0 / 3.0}
"""Of the patients, those known least, whose score decides."""
ELITES = 6
RETURN_S = 2.0  # after its last second a maneuver goes back to rest, and begins again
START = ("opening_with_swings_and_fore_aft",)
"""Maneuvers whose continuations are tried beside sampled targets."""


@dataclass(frozen=True)
class SequentialDesign(SearchSettings):
    """What is designed.

    Attributes:
        cohort: of the patients.
        horizon_s: length of the maneuver.
        goal: potential of ``jawenv.envs.rewards`` that shall grow.
        over: ``"mean"`` of the patients, or the ``"tail"`` third of them that is known least at the time.
        patients: how many, from ``jawenv.seeds.TUNING`` on.
        look_ahead_s: how far each plan looks.
        candidates: sequences of targets that are tried in a round.
        rounds: how often sequences are varied about the best ones.
        comfort_weight: nats that a second of discomfort is worth.
        seed: of the search.
    """

    cohort: str = "trismus"
    horizon_s: float = 10.0
    goal: Goal = "mixed"
    over: Over = "mean"
    patients: int = 24
    look_ahead_s: float = 3.0
    candidates: int = 48
    rounds: int = 5
    comfort_weight: float = 60.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: a field has a value that is not allowed.
        """
        self.check_choices(goal=Goal, over=Over)
        self.check_least(patients=1, rounds=1, candidates=ELITES, seed=0)
        if not 0.2 <= self.look_ahead_s <= 30.0:
            raise InputError(f"look_ahead_s is {self.look_ahead_s:g}; allowed: 0.2 to 30")
        if not 0.0 <= self.comfort_weight < float("inf"):
            raise InputError(f"comfort_weight is {self.comfort_weight:g}; allowed: 0 or more, finite")
        configure(self.env_kwargs)

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment."""
        return {"control": "targets", "cohort": self.cohort, "episode_s": self.horizon_s, "track_bound": False}

    @property
    def steps(self) -> int:
        """Control steps of the maneuver."""
        return configure(self.env_kwargs).steps

    def plan(self, name: str) -> Plan:
        """How the planner searches."""
        return Plan(
            name=name,
            description=name,
            horizon_s=self.look_ahead_s,
            candidates=self.candidates,
            rounds=self.rounds,
            elites=ELITES,
            maneuvers=START,
            clairvoyant=True,
            comfort_weight=self.comfort_weight,
            goal=self.goal,
            common=SHARE[self.over],
        )


class _Reporting(Planner):
    """Draws from a seed of its own, keeps its actions, and tells how many there are."""

    def __init__(self, plan: Plan, seed: int, report: Callable[[int], None]) -> None:
        self.actions: list[Action] = []
        self._own_seed, self._report = seed, report
        super().__init__(plan)

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """See ``Planner.reset``; the seed of the patients is not that of the search."""
        super().reset(num_envs, self._own_seed)

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See ``jawenv.protocol.Agent.predict``."""
        action, after = super().predict(observation, state, episode_start, deterministic)
        self.actions.append(action)
        self._report(len(self.actions))
        return action, after


def design_maneuver(design: SequentialDesign, about: dict[str, str], report: Callable[[int], None]) -> Maneuver:
    """Design a maneuver.

    Args:
        design: what is designed.
        about: name, title, description and source.
        report: is told the control steps done.
    """
    planner = _Reporting(design.plan(about["name"]), design.seed, report)
    recording = play(planner, patients=design.patients, seed=TUNING.start, env_kwargs=design.env_kwargs)
    period = float(recording.time[1])
    actions = np.array(planner.actions, dtype=np.float64)[:, 0]
    return maneuver_of_targets(targets_of(actions[None], period)[0], period, about, return_s=RETURN_S)
