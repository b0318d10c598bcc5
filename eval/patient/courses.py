"""Courses of treatments of some patients."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from eval.kept.entries import Entry
from eval.patient.treatments import Course, Treatment, first_treatment, next_treatment
from jawenv.anatomy import Patient
from jawenv.base.errors import InputError
from jawenv.base.progress import Progress

MOMENTS = 40
"""Kept of each treatment."""


@dataclass(frozen=True)
class Person:
    """Whom a course is played on."""

    name: str  # for the page and its file
    seed: int  # of the patient, the noise and the drift
    patient: Patient | None = None  # given by a file; drawn from the cohort by default


def persons(seed: int, number: int, files: Sequence[Path] = ()) -> list[Person]:
    """The patients of some files, or of a cohort at consecutive seeds.

    Args:
        seed: of the first one.
        number: how many are drawn where no file is given.
        files: of patients.
    """
    if number < 1:
        raise InputError(f"patients is {number}; allowed: 1 or more")
    if seed < 0:
        raise InputError(f"seed is {seed}; allowed: 0 or more")
    if not files:
        return [Person(str(seed + i), seed + i) for i in range(number)]
    people = [Person(path.stem, seed + i, Patient.load(path)) for i, path in enumerate(files)]
    for i, person in enumerate(people):
        if person.name in [earlier.name for earlier in people[:i]]:
            raise InputError(f"patient is {files[i]}, beside another file of that name; allowed: other names")
    return people


def play_courses(entry: Entry, course: Course, people: Sequence[Person], console: Console) -> list[list[Treatment]]:
    """Play a course on every patient.

    Args:
        entry: the maneuver or agent.
        course: how many treatments, and how much a patient changes between them.
        people: on whom.
        console: where progress is shown.

    Returns:
        The treatments of each patient, at some of their times.
    """
    played = []
    with Progress(len(people) * course.number, "treatments", console) as progress:
        for person in people:
            treatments = []
            for treatment in _treatments(entry, course, person):
                treatments.append(treatment.thinned(MOMENTS))
                progress.advance_to(progress.done + 1, f"patient {person.name}")
            played.append(treatments)
    return played


def _treatments(entry: Entry, course: Course, person: Person) -> Iterator[Treatment]:
    """The treatments of one patient; each but the first begins with the belief after the one before."""
    last = first_treatment(entry, person.seed, person.patient, untold=course.number == 1)
    yield last
    for number in range(2, course.number + 1):
        last = next_treatment(entry, last, number, course.drift, person.seed, person.patient)
        yield last
