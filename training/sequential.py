"""A maneuver designed second by second: each plan is the one after which a cohort's patients are known best.

Receding-horizon optimal experiment design (Goodwin & Payne 1977, chapter 6, has the one-step form): drawn patients are
moved at once, all by the same targets, and each second the planner of ``agents.planning`` searches how they go on, by
the mean score of the patients. It is quick, greedy, and free of any waveform.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.planning import Plan, Planner
from agents.replay import maneuver_of_targets, targets_of
from jawenv.errors import InputError
from jawenv.maneuvers import Maneuver
from jawenv.protocol import Action, Mask, Observation, State
from jawenv.rollout import play
from jawenv.seeds import TUNING

if TYPE_CHECKING:
    from training.optimise import Design

GOALS = {"worst": "mixed", "D": "uncertainty"}
"""The potential whose growth is searched, for each criterion; ``"worst"`` alone is too short-sighted."""
SHARES = {"mean": 1.0, "tail": 1.0 / 3.0}
HORIZON_S, CANDIDATES, ROUNDS, ELITES = 3.0, 48, 5, 6
COMFORT_WEIGHT = 60.0


class _Reported(Planner):
    """Tells the number of plans made."""

    def __init__(self, plan: Plan, report: Callable[[int], None]) -> None:
        self._tell = report
        super().__init__(plan)
        self.actions: list[Action] = []

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
        self._tell(len(self.actions))
        return action, after


def design_by_steps(design: Design, about: dict[str, str], report: Callable[[int], None]) -> Maneuver:
    """Design a maneuver for ``design.patients`` patients of a cohort.

    Args:
        design: cohort, horizon, criterion, patients and seed are read.
        about: name, title, description and source.
        report: is told the control steps done.

    Raises:
        InputError: a criterion, control mode or choice of patients that this search does not have.
    """
    if design.criterion not in GOALS:
        raise InputError(f"criterion is {design.criterion!r}; allowed step by step: {', '.join(GOALS)}")
    if design.over not in SHARES:
        raise InputError(f"over is {design.over!r}; allowed step by step: {', '.join(SHARES)}")
    plan = Plan(
        name=about["name"],
        description=about["description"],
        horizon_s=HORIZON_S,
        candidates=CANDIDATES,
        rounds=ROUNDS,
        elites=ELITES,
        maneuvers=("opening_with_swings_and_fore_aft",),
        comfort_weight=COMFORT_WEIGHT,
        clairvoyant=True,
        goal=GOALS[design.criterion],
        common=SHARES[design.over],
    )
    planner = _Reported(plan, report)
    kwargs: dict[str, Any] = {**design.env_kwargs, "control": "targets", "track_bound": False}
    recording = play(planner, patients=design.patients, seed=TUNING.start, env_kwargs=kwargs)
    period = float(recording.time[1])
    running = recording.valid[:, :-1].all(axis=0)
    actions = np.array(planner.actions, dtype=np.float64)[running, 0]
    return maneuver_of_targets(targets_of(actions[None], period)[0], period, about)
