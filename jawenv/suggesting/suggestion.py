"""The movement to record next: the shipped policy plays a simulated patient with the estimates of a recording.

Its targets are written down, and are played without looking. What the next recording will tell is expected from
patients drawn from the belief: the information of each simulated recording is added to that of the first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np

from jawenv.anatomy import MUSCLE_NAMES, Patient
from jawenv.anatomy.patient import LARGEST_B, LARGEST_F_O_N
from jawenv.anatomy.prior import Prior
from jawenv.base.errors import InputError
from jawenv.envs.asked import RANDOM, asked_muscles, checked_asked
from jawenv.inference.treatable import treatable
from jawenv.ladder import DEFAULT_ENV
from jawenv.metrics import score
from jawenv.playing.agents import Array, Mask
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.maneuvers.maneuver import goals_of
from jawenv.playing.maneuvers.written import maneuver_of_targets
from jawenv.playing.policies.named import named_agent
from jawenv.playing.rollout import play
from jawenv.recordings import defaults
from jawenv.recordings.identification import Identification
from jawenv.recordings.record import Record
from jawenv.recordings.untold.learnt import identified_with_errors
from jawenv.suggesting.search import searched_actions

_POLICY, _ASKED_POLICY, BESIDE = "apg_anyone", "apg_asked", "refined"
_SHORTEST_S, _LONGEST_S = 2.0, 30.0
_DRAWS = 16
"""Patients from the belief, for what is expected."""
_BUDGET = 1.0 / 300.0
"""Discomfort that the device keeps, share of the time."""
_TRIES, _APART = 20, 1000
"""Seeds of a patient, and from one to the next."""
_TIMES_S = 0.2
"""Between the points of the maneuver."""


@dataclass(frozen=True)
class _Expected:
    """The largest error bar after both recordings, for patients from the belief: median, and nine in ten."""

    median: float
    low: float
    high: float
    discomfort_s: float


@dataclass(frozen=True)
class _Suggestion:
    """A movement to record next, and its expected worth."""

    found: Identification  # of the recording
    maneuver: Maneuver
    worst_sd: float  # largest error bar now
    expected: _Expected  # with the maneuver
    beside: _Expected  # with ``BESIDE`` in its place
    again: float  # largest error bar if the next recording told what this one did
    patient: Patient  # whom the estimates describe
    seed: int  # with which the device can treat him
    world: dict[str, Any]  # arguments of the environment of the next recording

    def movement(self) -> str:
        """The movement in words."""
        goals = self.maneuver.targets(np.arange(0.0, self.seconds, _TIMES_S)).value
        opening, side, push, _ = goals.T
        turns = int(np.sum(np.diff(np.sign(side[np.abs(side) > 0.2])) != 0))
        pushes = [word for word, far in (("forward", push.max()), ("back", -push.min())) if far > 0.3]
        parts = [f"opens to {opening.max():.1f} of the painless range", f"{turns + 1} swings to the sides"]
        return ", ".join([*parts, *(["pushes " + " and ".join(pushes)] if pushes else [])])

    @property
    def seconds(self) -> float:
        """Length of the movement."""
        return max(point.t_s for point in self.maneuver.channels.opening.points)  # type: ignore[union-attr]


def suggest(
    record: Record,
    seconds: float = 10.0,
    search: int = 0,
    asked: str | None = None,
    announce: Callable[[str], None] = lambda text: None,
) -> _Suggestion:
    """Suggest the movement to record next of a recording's patient.

    Args:
        record: of the whole midline jaw, as ``load_record`` gives it.
        seconds: length of the next recording, 2 to 30.
        search: steps down the gradient of the twin from the policy's movement on, which take about five seconds each;
            what it finds is suggested where more is expected of it.
        asked: the muscle whose error bars count, or a word of several, as `left`; all by default.
        announce: called with what goes on, in words.

    Raises:
        InputError: another length, model or muscle, or a recording that is not to be believed.
        MissingPackageError: a search without the clone's packages.
    """
    if search < 0:
        raise InputError(f"search is {search}; allowed: 0 or more updates")
    if asked == RANDOM:
        raise InputError(f"asked is {asked!r}; allowed: a muscle, or a word of several, as left")
    checked_asked(asked, MUSCLE_NAMES)
    counted = np.repeat(asked_muscles(asked, MUSCLE_NAMES, np.zeros(2, dtype=np.uint64)), 2)
    if not _SHORTEST_S <= seconds <= _LONGEST_S:
        raise InputError(f"seconds is {seconds:g}; allowed: {_SHORTEST_S:g} to {_LONGEST_S:g}")
    model = defaults.model_of_geometry(record.jaw)
    if model is None or model[0] != "jaw":
        raise InputError("recording is of another jaw than the default one; allowed: that of jawenv/Jaw-v3")
    announce("identifying the recording")
    found, _ = identified_with_errors(record)
    if not found.believable:
        raise InputError(f"recording is not to be believed: {found.doubts[0]}; allowed: one that identify believes")
    mean, cov = found.estimate.mean[-1], found.estimate.cov[-1]
    world = {
        "cohort": "anyone",
        "control": "targets",
        "episode_s": seconds,
        "track_bound": False,
        "knowledge": record.knowledge,
        "force_sensor": record.force_sensor,
        "comfort_budget_s": _BUDGET * seconds,
        "asked": asked,
    }
    patients = [_as_patient(row, model[1]) for row in drawn_from(mean[None], cov[None], _DRAWS, 0)[0]]
    known, prior = np.linalg.inv(cov), np.diag(record.prior.sd**-2)
    announce("playing its estimates")
    believed = _as_patient(mean, model[1])
    actions = [suggested_actions([believed], world)]
    if search:
        actions.append(
            searched_actions(
                actions[0], patients, seeds_of(patients, world), mean[None], known[None], world, search, announce
            )
        )
    announce(f"playing {_DRAWS} patients from the belief")
    maneuvers = [*(_written_down(one[0], seconds) for one in actions), Maneuver.named(BESIDE)]
    *expected, beside = (_expected(Player(one), patients, world, known, counted) for one in maneuvers)
    best, maneuver = min(zip(expected, maneuvers, strict=False), key=lambda pair: pair[0].median)
    again = _worst(np.linalg.inv(2.0 * known - prior), counted)
    seed = seeds_of([believed], world)[0]
    return _Suggestion(found, maneuver, _worst(cov, counted), best, beside, again, believed, seed, world)


def _as_patient(theta: Array, tilt_deg: float = 0.0) -> Patient:
    """A patient of natural-log parameters, within what a patient can be."""
    most = np.tile(np.log([LARGEST_F_O_N, LARGEST_B]), len(theta) // 2)
    return Patient.from_log_parameters(np.minimum(theta, most - 1e-9), head_tilt_deg=tilt_deg)


def drawn_from(means: Array, covs: Array, draws: int, seed: int) -> Array:
    """Parameters (N, draws, p) that beliefs allow, of patients whom the device can treat.

    Args:
        means: (N, p) of the beliefs.
        covs: (N, p, p) of the same.
        draws: of each belief; where fewer can be treated these come again, and the mean where none can.
        seed: of the draw.
    """
    rng = np.random.default_rng(seed)
    rows = np.stack([rng.multivariate_normal(mean, cov, 2 * draws) for mean, cov in zip(means, covs, strict=True)])
    fit = treatable(rows.reshape(-1, means.shape[1])).reshape(rows.shape[:2])
    kept = [one[good] if good.any() else mean[None] for one, good, mean in zip(rows, fit, means, strict=True)]
    return np.stack([np.resize(one, (draws, means.shape[1])) for one in kept])


def seeds_of(patients: list[Patient], world: dict[str, Any]) -> list[int]:
    """A seed for each patient with which the device can treat him: some anatomies that a scan allows it cannot.

    Args:
        patients: N.
        world: arguments of the environment.

    Raises:
        InputError: no seed of several does.
    """
    env = gym.make_vec(DEFAULT_ENV, 1, **world)
    found = []
    for i, patient in enumerate(patients):
        for seed in range(i, i + _TRIES * _APART, _APART):
            try:
                env.reset(seed=seed, options={"patients": [patient]})
            except InputError as error:
                refused = error
                continue
            found.append(seed)
            break
        else:
            raise refused
    env.close()
    return found


def suggested_actions(patients: list[Patient], world: dict[str, Any]) -> Array:
    """Actions (N, T, 4) of the shipped policy for N patients in targets control.

    Args:
        patients: whom the estimates describe.
        world: arguments of the environment.
    """
    policy = named_agent(_ASKED_POLICY if world.get("asked") else _POLICY, "targets")
    assert policy is not None
    actions: list[Array] = []

    def note(env: Any, action: Any) -> None:
        if action is not None:
            actions.append(np.asarray(action))

    play(policy, patients=patients, seed=seeds_of(patients, world), env_kwargs=world, on_step=note)
    return np.stack(actions, axis=1)


def _written_down(actions: Array, seconds: float) -> Maneuver:
    """The targets of actions (T, 4), as a maneuver."""
    goals = goals_of(actions)
    text = "Suggested for the estimates of a recording."
    header = {"name": "next", "title": "Next", "description": text, "source": "jawenv suggest"}
    return maneuver_of_targets(goals, seconds / len(goals), header)


def _expected(player: Player, patients: list[Patient], world: dict[str, Any], known: Array, counted: Mask) -> _Expected:
    """Expected worth of a movement for patients beside the precision ``known`` (p, p), where ``counted`` (p,)."""
    played = play(player, patients=patients, seed=seeds_of(patients, world), env_kwargs=world)
    prior = Prior(played.prior_mean, played.prior_sd)
    gains = np.linalg.inv(played.belief_cov[:, -1]) - np.diag(prior.sd**-2)
    covs = [np.linalg.inv(known + one) for one in gains]
    low, median, high = np.quantile([_worst(cov, counted) for cov in covs], [0.05, 0.5, 0.95])
    return _Expected(float(median), float(low), float(high), float(score(played).discomfort_s.mean()))


def _worst(cov: Any, counted: Any) -> float:
    """Return the largest error bar among the counted ones (p,)."""
    return float(np.sqrt(np.diagonal(cov)[counted].max()))
