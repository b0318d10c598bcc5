"""Treatments of one patient, one after the other: each begins with the belief after the one before."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eval.kept.entries import Entry
from eval.patient.belief import KnownPatient, PatientBelief, at_start, is_shared
from jawenv.analysis.joint_likelihood import JointLikelihood, joint_likelihood
from jawenv.anatomy import Cohort, Patient, cohort
from jawenv.base.errors import InputError
from jawenv.ladder import model_of_env
from jawenv.metrics import alarm_rings
from jawenv.playing.recording import Recording
from jawenv.recordings.several.together import combined
from jawenv.recordings.untold.learnt import learnt
from jawenv.recordings.untold.shown import Shown

Array = NDArray[np.float64]

LARGEST_DRIFT = 0.5
REDRAWS = 50
"""Draws of a step of the drift, where it would make a patient whom the device cannot treat."""


@dataclass(frozen=True)
class Course:
    """A course of treatments."""

    number: int = 1  # of treatments, >= 1
    drift: float = 0.0
    """Sd of the normal step that each natural-log parameter makes between two treatments; 0.02 is 2 %."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.number < 1:
            raise InputError(f"treatments is {self.number}; allowed: 1 or more")
        if not (math.isfinite(self.drift) and 0.0 <= self.drift <= LARGEST_DRIFT):
            raise InputError(f"drift is {self.drift}; allowed: 0 to {LARGEST_DRIFT:g}; 0.02 is 2 %")


@dataclass(frozen=True)
class Treatment:
    """The belief during one treatment, at T times from its start to its end."""

    time: Array  # (T,) s since its start
    mean: Array  # (T, P) natural logs
    cov: Array  # (T, P, P)
    truth: Array  # (P,) the patient's natural-log parameters, the same during a treatment
    violated: bool  # whether it ended at a hard limit of comfort
    misfit: float  # the filter's alarm, the largest of the treatment
    information: Array = field(default_factory=lambda: np.empty((0, 0)))
    """(P + Q, P + Q) information of this treatment alone on the muscles and the patient's anatomy together, see
    ``JointLikelihood``; empty where the anatomy is known exactly.
    """
    vector: Array = field(default_factory=lambda: np.empty(0))  # (P + Q,) the same
    joint_mean: Array = field(default_factory=lambda: np.empty(0))
    """(P + Q,) joint belief at the end after all treatments so far; empty as well."""
    joint_cov: Array = field(default_factory=lambda: np.empty((0, 0)))  # (P + Q, P + Q)
    shown: Shown | None = None  # what tells whether to believe it, where the last belief has learnt untold errors

    @property
    def likelihood(self) -> JointLikelihood | None:
        """Likelihood of this treatment alone; None where the anatomy is known exactly."""
        return JointLikelihood(self.information, self.vector) if len(self.vector) else None

    @property
    def rings(self) -> bool:
        """Whether the alarm rings: the readings do not fit the model."""
        return bool(alarm_rings(np.array(self.misfit)))

    @property
    def nees(self) -> float:
        """Normalised squared error at the end; P on average where the belief is calibrated."""
        error = self.mean[-1] - self.truth
        return float(error @ np.linalg.solve(self.cov[-1], error))

    def thinned(self, number: int) -> Treatment:
        """The same at so many times or fewer, the first and the last among them, denser at the start."""
        share = np.linspace(0.0, 1.0, number) ** 2
        chosen = np.unique(np.round(share * (len(self.time) - 1)).astype(int))
        return replace(self, time=self.time[chosen], mean=self.mean[chosen], cov=self.cov[chosen])


def population_of(entry: Entry) -> Cohort:
    """The cohort that an entry's patients are of, with the muscles of its model."""
    return cohort(entry.env_kwargs["cohort"], model_of_env(entry.env_id).muscles)


def first_treatment(entry: Entry, seed: int, patient: Patient | None = None, *, untold: bool = False) -> Treatment:
    """The treatment that begins with the prior of the cohort.

    Args:
        entry: the maneuver or agent.
        seed: of the patient and the noise.
        patient: drawn from the entry's cohort by default, as `jawenv.play` draws it where the anatomy is known exactly.
        untold: whether the last belief learns the sizes of errors that nobody told, as `jawenv identify` does. A
            treatment that follows goes on from what the filter believes, as if there were none.
    """
    population = population_of(entry)
    if not is_shared(entry):
        return _play(entry, PatientBelief.of_prior(population.prior), patient, seed, untold)
    generator = np.random.default_rng(seed)
    for attempt in range(REDRAWS):
        drawn = population.draw(generator) if patient is None else patient
        try:
            return _play_shared(entry, None, _of_one_anatomy(drawn, seed), seed, untold)
        except InputError:
            if patient is not None or attempt == REDRAWS - 1:
                raise
    raise AssertionError("the last attempt returns or raises")


def next_treatment(
    entry: Entry, last: Treatment, number: int, drift: float, seed: int, patient: Patient | None = None
) -> Treatment:
    """The treatment that begins with the belief after the last one.

    Every parameter has made a normal step since, and the belief is widened by as much. A step that makes a patient whom
    the device cannot treat is drawn again.

    Args:
        entry: the maneuver or agent.
        last: treatment number - 1.
        number: of this treatment; the first is 1.
        drift: sd of the step.
        seed: of the patient; noise and step follow from it and the number.
        patient: source of name, anatomy and tilt of the head; a drawn one by default.
    """
    population, shared = population_of(entry), is_shared(entry)
    noise, step = np.random.SeedSequence((seed, number)).spawn(2)
    noises = noise.generate_state(REDRAWS).tolist()
    generator = np.random.default_rng(step)
    name, tilt = (population.name, 0.0) if patient is None else (patient.name, patient.head_tilt_deg)
    anatomy_seed = None if patient is None else patient.anatomy_seed
    for attempt in range(REDRAWS):
        truth = last.truth + drift * generator.standard_normal(len(last.truth))
        try:
            changed = Patient.from_log_parameters(
                truth, name=name, head_tilt_deg=tilt, muscles=population.muscles.names
            ).model_copy(update={"anatomy_seed": anatomy_seed})
            if shared:
                # How the device sits is drawn with the noise, and decides with whom it can treat.
                return _play_shared(entry, _widened(last, drift), _of_one_anatomy(changed, seed), noises[attempt])
            return _play(entry, PatientBelief(last.mean[-1], last.cov[-1]).widened(drift), changed, noises[0])
        except InputError:
            if (drift == 0.0 and not shared) or attempt == REDRAWS - 1:
                raise
    raise AssertionError("the last attempt returns or raises")


def _play(entry: Entry, belief: PatientBelief, patient: Patient | None, noise: int, untold: bool = False) -> Treatment:
    """One treatment that begins with a belief."""
    population = population_of(entry)
    working = belief.working_prior(population.prior)
    cohort = KnownPatient.of(population, working)
    recording = entry.play([patient], noise, cohort=cohort, track_bound=False, record=untold)
    last = recording.last[0] + 1
    means, covs = recording.belief_mean[0, :last], recording.belief_cov[0, :last]
    mean, cov = combined((belief.mean, belief.cov), working, means, covs)
    played = Treatment(recording.time[:last], mean, cov, recording.truth[0], *_outcome(recording))
    return _with_errors(played, recording)


def _play_shared(
    entry: Entry, before: tuple[Array, Array] | None, patient: Patient, noise: int, untold: bool = False
) -> Treatment:
    """One treatment that begins with a belief about muscles and anatomy together; None is the prior."""
    population = population_of(entry)
    working, parameters = population.prior, len(population.prior.mean)
    if before is not None:
        mean, cov = (values[:parameters] for values in before)
        working = PatientBelief(mean, cov[:, :parameters]).working_prior(population.prior)
    heard: list[JointLikelihood] = []  # of the filter after each step, the reset first

    def hear(env: Any, action: Any) -> None:
        heard.append(joint_likelihood(env.unwrapped.simulation, 0))

    cohort = KnownPatient.of(population, working)
    recording = entry.play([patient], noise, on_step=hear, cohort=cohort, track_bound=False, record=untold)
    last = int(recording.last[0]) + 1
    likelihoods = heard[:last]
    start = before or at_start(population.prior, len(likelihoods[0].vector))
    beliefs = [likelihood.posterior(*start) for likelihood in likelihoods]
    played = Treatment(
        recording.time[:last],
        np.array([mean[:parameters] for mean, _ in beliefs]),
        np.array([cov[:parameters, :parameters] for _, cov in beliefs]),
        recording.truth[0],
        *_outcome(recording),
        likelihoods[-1].information,
        likelihoods[-1].vector,
        *beliefs[-1],
    )
    return _with_errors(played, recording)


def _with_errors(treatment: Treatment, recording: Recording) -> Treatment:
    """The treatment, its last belief with the sizes of errors that nobody told where readings were kept."""
    last = None if recording.records is None else learnt(recording.records[0], treatment.mean[-1], treatment.cov[-1])
    if last is None:
        return treatment
    mean, cov = treatment.mean.copy(), treatment.cov.copy()
    mean[-1], cov[-1] = last.mean, last.cov
    return replace(treatment, mean=mean, cov=cov, shown=last.shown)


def _outcome(recording: Recording) -> tuple[bool, float]:
    """Whether a hard limit was crossed, and the alarm."""
    return bool(recording.violation[0].any()), float(recording.at_end(recording.misfit)[0])


def _widened(last: Treatment, drift: float) -> tuple[Array, Array]:
    """Joint belief on muscles and anatomy after each muscle's step; the anatomy makes none."""
    steps = np.zeros(len(last.joint_mean))
    steps[: len(last.truth)] = drift**2
    return last.joint_mean, last.joint_cov + np.diag(steps)


def _of_one_anatomy(patient: Patient, seed: int) -> Patient:
    """The patient with an anatomy: its own, or one drawn by the seed."""
    if patient.anatomy_seed is not None:
        return patient
    own = int(np.random.SeedSequence((seed, 0)).generate_state(1)[0])
    return patient.model_copy(update={"anatomy_seed": own})
