"""A maneuver designed second by second: each plan is the one after which a cohort's patients are known best.

Receding-horizon optimal experiment design (the one-step form is in Goodwin & Payne 1977, chapter 6): drawn patients are
moved at once, all by the same targets, and each second the planner of ``agents.planning`` searches how they go on, by
the mean score of the patients. It is quick, greedy, and free of any waveform. What follows the last second is the way
back to rest, and all again.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from agents.array_files import load_arrays, save_arrays
from agents.planning import Plan, Planner
from agents.replay import maneuver_of_targets, targets_of
from jawenv.envs.configuration import configure
from jawenv.errors import InputError
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.player import action_of
from jawenv.playing.protocol import Array, Mask
from jawenv.playing.rollout import play
from jawenv.seeds import TUNING
from training.search.session import SearchSettings

Goal = Literal["mixed", "worst", "uncertainty"]
Over = Literal["mean", "tail"]

SHARE = {"mean": 1.0, "tail": 1.0 / 3.0}
"""``over`` -> share of the patients that decides, the least known ones."""
ELITES = 6
RETURN_S = 2.0  # after its last second a maneuver goes back to rest, and begins again
START = ("opening_with_swings_and_fore_aft",)
"""Maneuvers to be continued beside sampled targets."""


@dataclass(frozen=True)
class SequentialDesign(SearchSettings):
    """Settings of the design.

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
        self.check_least(patients=1, rounds=1, seed=0)
        if not 0.2 <= self.look_ahead_s <= 30.0:
            raise InputError(f"look_ahead_s is {self.look_ahead_s:g}; allowed: 0.2 to 30")
        if not 0.0 <= self.comfort_weight < float("inf"):
            raise InputError(f"comfort_weight is {self.comfort_weight:g}; allowed: 0 or more, finite")
        configure(self.env_kwargs)
        self.plan("design")

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


class _Designer(Planner):
    """A planner that draws from a seed of its own, and keeps its plans in a log: those it finds there it does not make.

    Worlds are deterministic and a plan's candidates depend on the step alone, so that the plans are all there is to
    keep.

    Attributes:
        kept: plans that the log held at the beginning.
        plans: (H, 4) targets of each plan so far.
    """

    def __init__(self, design: SequentialDesign, name: str, log: Path) -> None:
        self._design, self._path = design, log
        super().__init__(design.plan(name))

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """See ``Planner.reset``; the search has a seed of its own."""
        super().reset(num_envs, self._design.seed)
        self.plans: list[Array] = []

    def attach(self, env: Any) -> None:
        """See ``Planner.attach``; reads the log.

        Raises:
            InputError: the log cannot be read, is damaged, or is of another search.
        """
        super().attach(env)
        finished = read_plans(self._path, self._design, self._planned.shape[1:])
        self.kept, self._left = len(finished), iter(finished)

    def actions(self, steps: int) -> Array:
        """Actions (steps, 4) that follow each plan until the next."""
        followed = np.concatenate([plan[: self._follow] for plan in self.plans])[:steps]
        return action_of(followed).astype(np.float32).astype(np.float64)

    def _search(self, step: Array, due: Mask) -> None:
        plan = next(self._left, None)
        if plan is None:
            super()._search(step, due)
        else:
            self._planned[due] = plan
            self._planned_at[due] = step[due]
        self.plans.append(self._planned[np.flatnonzero(due)[0]].copy())  # all worlds have the same
        if plan is None:
            write_plans(self._path, self._design, np.array(self.plans))


def write_plans(path: Path, design: SequentialDesign, plans: Array) -> None:
    """Keep the plans (n, H, 4) of a design so far."""
    save_arrays(path, plans=plans, settings=_settings(design))


def read_plans(path: Path, design: SequentialDesign, shape: tuple[int, ...]) -> Array:
    """The plans (n, H, 4) of a design so far; none if there is no such file.

    Args:
        path: where they are kept (.npz).
        design: settings of the plans.
        shape: of a plan.

    Raises:
        InputError: the file cannot be read, is damaged, or is of another design.
    """
    if not path.exists():
        return np.zeros((0, *shape))
    plans, settings = load_arrays(path, ("plans", "settings"), "plans of a design")
    if settings.tolist() != _settings(design):
        raise InputError(f"{path} is of another search; allowed: the same settings, or --overwrite")
    if plans.shape[1:] != shape or plans.dtype != np.float64 or not np.isfinite(plans).all():
        raise InputError(
            f"{path} is damaged: plans are no (n, {shape[0]}, {shape[1]}) numbers; --overwrite begins anew"
        )
    return plans


def _settings(design: SequentialDesign) -> str:
    return json.dumps(design.about(), sort_keys=True)


def design_maneuver(
    design: SequentialDesign, header: dict[str, str], log: Path, report: Callable[[int, bool], None]
) -> tuple[Maneuver, int]:
    """Design a maneuver, and keep its plans in ``log``, from which a design that was stopped goes on.

    Args:
        design: settings.
        header: name, title, description and source.
        log: an .npz; made if it does not exist.
        report: called after each control step with the number done and whether its plan was made now, not kept.

    Returns:
        The maneuver, and how many plans were made now.

    Raises:
        InputError: the log cannot be read or written, is damaged, or is of another search.
    """
    planner = _Designer(design, header["name"], log)
    recording = play(
        planner,
        patients=design.patients,
        seed=TUNING.start,
        env_kwargs=design.env_kwargs,
        progress=lambda step, _: report(step, len(planner.plans) > planner.kept),
    )
    period = float(recording.time[1])
    actions = planner.actions(len(recording.time) - 1)
    maneuver = maneuver_of_targets(targets_of(actions[None], period)[0], period, header, return_s=RETURN_S)
    return maneuver, len(planner.plans) - planner.kept
