"""Optimal experiment design: search the maneuver after which a cohort's parameters are known best, within comfort.

CMA-ES (Hansen & Ostermeier 2001, Evol. Comput. 9:159) over the numbers of ``waveform``; or over those of ``knots``
about a maneuver that is refined, by the form with a diagonal covariance (Ros & Hansen 2008, PPSN X, 296), since they
are a hundred. All candidates of a generation are played with the same patients and the same noise, in one call of the
batched core. Comfort is a constraint: a
candidate that breaks it ranks behind all that keep it, by how far it does (Deb 2000, Comput. Methods Appl. Mech. Eng.
186:311), which CMA-ES, knowing ranks alone, needs no weight for.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import cma
import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import jawenv
from jawenv.anatomy import MUSCLE_NAMES, Patient
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.envs.configuration import configure
from jawenv.errors import InputError
from jawenv.ladder import env_id_of, model_of_env
from jawenv.playing.maneuvers import Maneuver, Player, maneuver_names
from jawenv.playing.maneuvers.maneuver import Targets
from jawenv.seeds import TUNING
from training.search.knots import Knots
from training.search.log import SearchLog
from training.search.settings import SearchSettings
from training.search.waveform import Sines

Array = NDArray[np.float64]
Criterion = Literal["worst", "D", "A"]
Over = Literal["mean", "tail", "nominal"]

WEIGHTS = {0.35: 0.2, 0.65: 0.2, 1.0: 0.6}  # of what is known at these shares of the horizon
TAIL = 1.0 / 3.0  # of the patients, those known least, that ``over="tail"`` looks at
DISCOMFORT_S = 0.03 / 30.0  # mean discomfort per second of the episode that is allowed
GOVERNOR = 0.02  # share of the time with the governor at work that is allowed
MOST_WORLDS = 10_000  # that are played at once; each takes about a megabyte
INFEASIBLE = 1e3  # worse than any criterion
CANDIDATE = dict.fromkeys(("name", "title", "description", "source"), "candidate")


@dataclass(frozen=True)
class Design(SearchSettings):
    """What is searched.

    Attributes:
        cohort: of the patients.
        control: mode of the environment in which candidates are played.
        horizon_s: length of an episode.
        criterion: ``"worst"``: log of the largest sd of a parameter; ``"D"``: log-determinant of the covariance over
            twice the number of parameters; ``"A"``: half the log of the mean variance.
        over: ``"mean"`` of the patients, the ``"tail"`` third of them that is known least, or one ``"nominal"``
            patient, who has the medians of the cohort.
        patients: how many, from ``jawenv.seeds.TUNING`` on.
        generations: of CMA-ES.
        population: candidates in a generation.
        sigma: first step size, of numbers from 0 to 1.
        refine: name or file of the maneuver that is refined; empty: two sines on each channel are searched.
        then: name or file of the maneuver that follows a refined one after the horizon; empty: it goes on itself.
        seed: of the search.
        env: the environment, as `jawenv.ladder.model_of_env` takes it.
    """

    cohort: str = "trismus"
    control: Control = DEFAULT_CONTROL
    horizon_s: float = 10.0
    criterion: Criterion = "worst"
    over: Over = "mean"
    patients: int = 12
    generations: int = 120
    population: int = 14
    sigma: float = 0.12
    refine: str = ""
    then: str = ""
    seed: int = 0
    env: str = "Jaw"

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: a field has a value that is not allowed.
        """
        self.check_choices(criterion=Criterion, over=Over)
        self.check_least(patients=1, generations=1, population=4, seed=0)
        if self.population * self.patients > MOST_WORLDS:
            given = f"population is {self.population} and patients {self.patients}"
            raise InputError(f"{given}; allowed: {MOST_WORLDS:,} worlds, population times patients, at most")
        if not 0.0 < self.sigma <= 1.0:
            raise InputError(f"sigma is {self.sigma:g}; allowed: above 0, at most 1")
        configure(self.env_kwargs | {"model": model_of_env(self.env).name})
        self.form()

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment."""
        return {"control": self.control, "cohort": self.cohort, "episode_s": self.horizon_s}

    def form(self) -> Sines | Knots:
        """What makes maneuvers of numbers.

        Raises:
            InputError: a maneuver is unknown, or its file is wrong, or one follows where none is refined.
        """
        if not self.refine:
            if self.then:
                raise InputError(f"then is {self.then!r}; allowed: nothing without refine")
            return Sines()
        return Knots(_maneuver(self.refine), self.horizon_s, _maneuver(self.then) if self.then else None)


def _maneuver(spec: str) -> Maneuver:
    """A maneuver by its name or from its file."""
    return Maneuver.named(spec) if spec in maneuver_names() else Maneuver.load(spec)


class Judged(NamedTuple):
    """A candidate's figures.

    Attributes:
        loss: what CMA-ES ranks.
        criterion: without constraints.
        discomfort_s: mean over the patients.
        violated: share of the patients whose hard limit was crossed.
        governor: share of the time with the governor at work.
        worst_sd: median over the patients of the largest sd at the horizon.
    """

    loss: float
    criterion: float
    discomfort_s: float
    violated: float
    governor: float
    worst_sd: float

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
        each = [maneuver.targets(time[:1]) for maneuver in self._maneuvers]
        value, rate = (np.concatenate([getattr(one, name) for one in each]) for name in ("value", "rate"))
        return Targets(np.repeat(value, self._patients, axis=0), np.repeat(rate, self._patients, axis=0))


class Judge:
    """Plays candidates and says how good they are.

    Args:
        design: what is searched.
    """

    def __init__(self, design: Design) -> None:
        self._design = design
        self._env: Any = None

    def __call__(self, candidates: Sequence[Maneuver]) -> list[Judged]:
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
        known = np.zeros(worlds)
        for step in range(configuration.steps):
            observation, _, _, _, info = self._env.step(player.predict(observation)[0])
            discomfort += info["cost"] / configuration.steps_per_s
            violated |= info["violation"]
            governor += info["governor"] / configuration.steps
            if weight := sum(weight for end, weight in ends if end == step + 1):
                known += weight * self._criterion(info["belief_cov"])
        worst = np.sqrt(np.diagonal(info["belief_cov"], axis1=1, axis2=2)).max(axis=1)
        columns = (known, discomfort, violated, governor, worst)
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

    def _judge(self, known: Array, discomfort: Array, violated: Array, governor: Array, worst: Array) -> Judged:
        """One candidate's figures from those of its patients."""
        tail = max(1, round(TAIL * len(known)))
        value = float(np.sort(known)[-tail:].mean() if self._design.over == "tail" else known.mean())
        excess = max(0.0, float(discomfort.mean()) / (DISCOMFORT_S * self._design.horizon_s) - 1.0)
        excess += max(0.0, float(governor.mean()) / GOVERNOR - 1.0) + 100.0 * float(violated.mean())
        loss = value if excess == 0.0 else INFEASIBLE + excess
        means = float(discomfort.mean()), float(violated.mean()), float(governor.mean())
        return Judged(loss, value, *means, float(np.median(worst)))


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
    judged: Judged


def search(
    design: Design,
    log: Path,
    report: Callable[[int, Found], None],
    judge: Callable[[Sequence[Maneuver]], list[Judged]] | None = None,
) -> Found:
    """Search, and keep the losses of every generation in ``log``, from which a search that was stopped goes on.

    CMA-ES draws its candidates from its seed and the losses so far, so that the losses are all there is to keep.

    Args:
        design: what is searched.
        log: text file, one line of losses for each generation; made if it does not exist.
        report: called after each generation with the number done and the best so far.
        judge: of candidates; ``Judge`` by default.

    Returns:
        The best candidate.

    Raises:
        InputError: the log is damaged, or of another search.
    """
    judge, form = judge or Judge(design), design.form()
    options = {"popsize": design.population, "seed": design.seed + 1, "verbose": -9, "maxiter": design.generations}
    options["CMA_diagonal"] = bool(design.refine)
    strategy = cma.CMAEvolutionStrategy(form.start, design.sigma, options)
    settings = {name: value for name, value in design.about().items() if name != "generations"}
    if isinstance(form, Knots):
        settings["refined"] = hashlib.sha256(form.base.model_dump_json().encode()).hexdigest()[:16]
    losses_so_far = SearchLog(log, settings, design.population)
    kept = losses_so_far.rows()
    best: Array | None = None
    lowest = np.inf
    for generation in range(design.generations):
        asked = strategy.ask()
        if generation < len(kept):
            losses = kept[generation]
        else:
            losses = [one.loss for one in judge([form.maneuver(numbers, CANDIDATE) for numbers in asked])]
            losses_so_far.append(losses)
        strategy.tell(asked, losses)
        if min(losses) < lowest:
            lowest, best = min(losses), asked[int(np.argmin(losses))]
        if generation + 1 > len(kept):
            assert best is not None
            report(generation + 1, Found(best, Judged(lowest, lowest, *[np.nan] * 4)))
    assert best is not None
    return Found(best, judge([form.maneuver(best, CANDIDATE)])[0])
