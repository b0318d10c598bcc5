"""Optimal experiment design: refine a maneuver until a cohort's parameters are known best after it, within comfort.

What is searched are offsets of the maneuver's targets at knots, joined by straight lines: a maneuver that was designed
second by second has plans that do not see its end, a search over the whole of it does. It is CMA-ES (Hansen &
Ostermeier 2001, Evol. Comput. 9:159) with a diagonal covariance (Ros & Hansen 2008, PPSN X, 296), since the numbers
are a hundred. All candidates of a generation are played with the same patients and the same noise, in one call of the
batched core. Comfort is a constraint: a candidate that breaks it ranks behind all that keep it, by how far it does
(Deb 2000, Comput. Methods Appl. Mech. Eng. 186:311), which CMA-ES, knowing ranks alone, needs no weight for.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import cma
import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import jawenv
from agents.replay import followed
from jawenv.anatomy import MUSCLE_NAMES, Patient
from jawenv.base.errors import InputError
from jawenv.base.files import atomic_write
from jawenv.base.reading import read_bytes
from jawenv.base.seeds import TUNING
from jawenv.controls import Control
from jawenv.device.channels import CHANNELS, HIGHEST, LOWEST
from jawenv.ladder import env_id_of
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.maneuvers.maneuver import Targets
from jawenv.playing.maneuvers.signals import Keyframes
from jawenv.playing.maneuvers.written import maneuver_of_targets
from training.search.settings import Refinement

Array = NDArray[np.float64]

WEIGHTS = {0.35: 0.2, 0.65: 0.2, 1.0: 0.6}  # of the criterion at these shares of the horizon
TAIL = 1.0 / 3.0  # of the patients, those known least, that ``over="tail"`` looks at
DISCOMFORT_S = 0.03 / 30.0  # mean discomfort per second of the episode that is allowed
GOVERNOR = 0.02  # share of the time with the governor at work that is allowed
INFEASIBLE = 1e3  # worse than any criterion
RETURN_S = 2.0  # from the horizon to rest
STEP_S = 0.2  # between targets of the maneuver that is made
KNOT_S = 0.4  # between knots
SIZE = np.array([0.25, 0.4, 0.1, 0.4])
"""Unit of the numbers of each channel, as a fraction of the patient's comfort."""
CANDIDATE = dict.fromkeys(("name", "title", "description", "source"), "candidate")


class Knots:
    """A maneuver, and offsets of its targets until a horizon.

    Args:
        base: the maneuver.
        horizon_s: where the last knot lies.

    Attributes:
        start: (n,) zeros: the maneuver itself.
    """

    def __init__(self, base: Maneuver, horizon_s: float) -> None:
        self.base = base
        times: Array = STEP_S * np.arange(1.0, round(max(horizon_s, _length_s(base)) / STEP_S) + 1)
        self._targets: Array = base.targets(times).value
        knots = KNOT_S * np.arange(1, max(1, round(horizon_s / KNOT_S)) + 1)
        self._weights = np.clip(1.0 - np.abs(times[:, None] - knots) / KNOT_S, 0.0, None)
        self.start = np.zeros(len(knots) * len(CHANNELS))

    def targets(self, numbers: Array) -> Array:
        """Targets (T, 4) every ``STEP_S``, as far and as fast as the device lets them, from any real numbers (n,)."""
        offsets = self._weights @ (np.reshape(numbers, (-1, len(CHANNELS))) * SIZE)
        goals = np.clip(self._targets + offsets, np.array(LOWEST), HIGHEST)
        path: Array = followed(goals[None], STEP_S)[0]
        return path

    def maneuver(self, numbers: Array, header: dict[str, str]) -> Maneuver:
        """The maneuver of numbers (n,), with name, title, description and source; it goes back to rest and repeats."""
        return maneuver_of_targets(self.targets(numbers), STEP_S, header, return_s=RETURN_S)


def _length_s(maneuver: Maneuver) -> float:
    """Length of a maneuver of keyframes until it goes back to rest (s); 0 for one that has other signals."""
    signals = [maneuver.channels.signal(name) for name in CHANNELS]
    keyframes = [signal for signal in signals if isinstance(signal, Keyframes)]
    last = max((signal.points[-1].t_s for signal in keyframes), default=0.0)
    return max(0.0, last - RETURN_S) if len(keyframes) == len(signals) else 0.0


def knots_of(design: Refinement) -> Knots:
    """The maneuver with offsets of its targets."""
    return Knots(design.maneuver(), design.horizon_s)


class _Judged(NamedTuple):
    """A candidate's figures."""

    loss: float  # figure that CMA-ES ranks
    criterion: float  # without constraints
    discomfort_s: float  # mean over the patients
    violated: float  # share of the patients with a hard limit crossed
    governor: float  # share of the time with the governor at work
    worst_sd: float  # median over the patients of the largest sd at the horizon

    @property
    def feasible(self) -> bool:
        """Whether it keeps the constraints."""
        return self.loss < 0.5 * INFEASIBLE


class _Candidates(Player):
    """Maneuvers played at once, each in as many worlds that follow one another as there are patients."""

    def __init__(self, maneuvers: Sequence[Maneuver], patients: int, control: Control, control_hz: float) -> None:
        super().__init__(maneuvers[0], control=control, control_hz=control_hz)
        self._maneuvers, self._patients = maneuvers, patients

    def targets(self, time: Array) -> Targets:
        """Targets of all worlds, at the time of the first."""
        parts = [maneuver.targets(time[:1]) for maneuver in self._maneuvers]
        value, rate = (np.concatenate([getattr(one, name) for one in parts]) for name in ("value", "rate"))
        return Targets(np.repeat(value, self._patients, axis=0), np.repeat(rate, self._patients, axis=0))


class Judge:
    """Plays candidates and says how good they are.

    Args:
        design: settings of the search.
    """

    def __init__(self, design: Refinement) -> None:
        self._design = design
        self._env: Any = None

    def __call__(self, candidates: Sequence[Maneuver]) -> list[_Judged]:
        """Figures of every candidate, all played with the same patients and noise."""
        design = self._design
        patients = 1 if design.over == "nominal" else design.patients
        worlds = patients * len(candidates)
        if self._env is None or self._env.num_envs != worlds:
            self._env = gym.make_vec(env_id_of(design.env), worlds, autoreset_mode="disabled", **design.env_kwargs)
        configuration = self._env.configuration
        seeds = [TUNING.start + i for i in range(patients)] * len(candidates)
        options = {"patients": [nominal_patient(design.cohort)] * worlds} if design.over == "nominal" else None
        observation, info = self._env.reset(seed=seeds, options=options)
        player = _Candidates(candidates, patients, design.control, configuration.steps_per_s)
        discomfort, violated, governor = np.zeros(worlds), np.zeros(worlds, dtype=bool), np.zeros(worlds)
        ends = [(max(1, round(share * configuration.steps)), weight) for share, weight in WEIGHTS.items()]
        uncertainty = np.zeros(worlds)
        for step in range(configuration.steps):
            observation, _, _, _, info = self._env.step(player.predict(observation)[0])
            discomfort += info["cost"] / configuration.steps_per_s
            violated |= info["violation"]
            governor += info["governor"] / configuration.steps
            if weight := sum(weight for end, weight in ends if end == step + 1):
                uncertainty += weight * self._criterion(info["belief_cov"])
        worst = np.sqrt(np.diagonal(info["belief_cov"], axis1=1, axis2=2)).max(axis=1)
        columns = (uncertainty, discomfort, violated, governor, worst)
        return [self._judge(*parts) for parts in zip(*(c.reshape(len(candidates), -1) for c in columns), strict=True)]

    def _criterion(self, covariance: Array) -> Array:
        """The criterion (N,) of covariances (N, p, p); smaller is better."""
        variances = np.diagonal(covariance, axis1=1, axis2=2)
        values: Array
        if self._design.criterion == "worst":
            values = 0.5 * np.log(variances.max(axis=1))
        elif self._design.criterion == "A":
            values = 0.5 * np.log(variances.mean(axis=1))
        else:
            values = np.linalg.slogdet(covariance)[1] / (2.0 * covariance.shape[1])
        return np.where(np.isfinite(values), values, INFEASIBLE)

    def _judge(self, uncertainty: Array, discomfort: Array, violated: Array, governor: Array, worst: Array) -> _Judged:
        """One candidate's figures from its patients' figures."""
        tail = max(1, round(TAIL * len(uncertainty)))
        value = float(np.sort(uncertainty)[-tail:].mean() if self._design.over == "tail" else uncertainty.mean())
        excess = max(0.0, float(discomfort.mean()) / (DISCOMFORT_S * self._design.horizon_s) - 1.0)
        excess += max(0.0, float(governor.mean()) / GOVERNOR - 1.0) + 100.0 * float(violated.mean())
        loss = value if excess == 0.0 else INFEASIBLE + excess
        means = float(discomfort.mean()), float(violated.mean()), float(governor.mean())
        return _Judged(loss, value, *means, float(np.median(worst)))


def nominal_patient(cohort: str) -> Patient:
    """The patient of a cohort's prior means: medians of F_o and b."""
    mean = jawenv.cohort(cohort).prior.mean.reshape(-1, 2)
    force, exponent = np.exp(mean).T
    return Patient(
        name="nominal",
        F_o_N=dict(zip(MUSCLE_NAMES, force.tolist(), strict=True)),
        b=dict(zip(MUSCLE_NAMES, exponent.tolist(), strict=True)),
    )


class Found(NamedTuple):
    """The best candidate so far: its numbers, and its figures."""

    numbers: Array
    judged: _Judged


def search(
    design: Refinement,
    log: Path,
    report: Callable[[int, float], None],
    judge: Callable[[Sequence[Maneuver]], list[_Judged]] | None = None,
) -> Found:
    """Search, and keep the state after every generation in ``log``, from which a search that was stopped goes on.

    Args:
        design: settings of the search.
        log: a pickle of cma's; made if it does not exist. Reading it can run code: it must be the user's own.
        report: called after each generation with the number done and the lowest loss so far.
        judge: of candidates; ``Judge`` by default.

    Returns:
        The best candidate.
    """
    judge, knots = judge or Judge(design), knots_of(design)
    settings = design.about() | {"generations": None, "refined": knots.base.model_dump_json()}
    if log.exists():
        strategy = _resumed(log, settings)
    else:
        options = {"popsize": design.population, "seed": design.seed + 1, "verbose": -9, "CMA_diagonal": True}
        strategy = cma.CMAEvolutionStrategy(knots.start, design.sigma, options)
    if strategy.countiter > design.generations:
        raise InputError(f"generations is {design.generations}; allowed: {strategy.countiter}, done so far, or more")
    while strategy.countiter < design.generations:
        asked = strategy.ask()
        strategy.tell(asked, [one.loss for one in judge([knots.maneuver(numbers, CANDIDATE) for numbers in asked])])
        with atomic_write(log) as unfinished:
            # cma draws from NumPy's global stream.
            unfinished.write_bytes(pickle.dumps((settings, strategy.pickle_dumps(), np.random.get_state())))
        report(strategy.countiter, strategy.best.f)
    best = strategy.best.x
    return Found(best, judge([knots.maneuver(best, CANDIDATE)])[0])


def _resumed(log: Path, settings: dict[str, Any]) -> Any:
    """The strategy as a search has left it, and NumPy's global stream with it."""
    try:
        saved, strategy, stream = pickle.loads(read_bytes(log))
        if saved == settings:
            np.random.set_state(stream)
            return pickle.loads(strategy)
    except InputError:
        raise
    except Exception as error:  # a damaged pickle can raise anything
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(f"{log} is damaged: {reason}; --overwrite begins anew") from None
    other = [name for name, value in settings.items() if saved.get(name) != value]
    raise InputError(f"{log} is of another search ({', '.join(other)}); allowed: the same settings, or --overwrite")
