"""Courses of treatments of some patients, each treatment kept on disk as soon as it is over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console

from agents.array_files import load_arrays, save_arrays
from eval.kept.digest import fingerprint
from eval.kept.entries import Entry
from eval.kept.parts import Part, Run, finish, folder_for
from eval.patient import belief, treatments
from eval.patient.treatments import Course, Treatment, first_treatment, next_treatment
from jawenv.anatomy import Patient
from jawenv.base.errors import InputError
from jawenv.base.progress import Progress
from jawenv.recordings.untold.shown import Shown

MOMENTS = 40
"""Kept of each treatment."""
_OF_TREATMENT = tuple(field.name for field in fields(Treatment) if field.name != "shown")
_OF_SHOWN = tuple(field.name for field in fields(Shown))


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


def play_courses(
    entry: Entry,
    course: Course,
    people: Sequence[Person],
    output: Path,
    *,
    fresh: bool = False,
    console: Console | None = None,
) -> list[list[Treatment]]:
    """Play a course on every patient.

    Args:
        entry: the maneuver or agent.
        course: how many treatments, and how much a patient changes between them.
        people: on whom.
        output: folder; its ``treatments`` holds finished ones, and an interrupted course goes on there.
        fresh: play kept treatments again.
        console: where progress is shown; nowhere by default.

    Returns:
        The treatments of each patient, at some of their times.
    """
    folder, parts = folder_for(output, "treatments"), []
    for person in people:
        patient = None if person.patient is None else person.patient.model_dump()
        settings = {"seed": person.seed, "drift": course.drift, "patient": patient, "moments": MOMENTS}
        name = fingerprint(entry, settings | {"untold": course.number == 1}, belief, treatments)
        paths = {str(number): folder / f"{name}-{number:04d}.npz" for number in range(1, course.number + 1)}
        parts.append(Part(person.name, 1, 1, tuple(paths.items())))
    work = partial(_play_course, entry=entry, drift=course.drift, people={person.name: person for person in people})
    by_path = finish(parts, work, load, "treatments", Run(fresh, 1, console=console))
    return [[by_path[path] for _, path in part.files] for part in parts]


def _play_course(part: Part, progress: Progress, entry: Entry, drift: float, people: Mapping[str, Person]) -> None:
    """Play the missing treatments of a course; each but the first begins with the belief after the one before."""
    person, before = people[part.key], progress.done
    for played, (kind, path) in enumerate(part.files, start=1):
        number = int(kind)
        if number == 1:
            treatment = first_treatment(entry, person.seed, person.patient, untold=len(part.files) == 1)
        else:
            last = load(path.with_name(path.name.replace(f"-{number:04d}.", f"-{number - 1:04d}.")))
            treatment = next_treatment(entry, last, number, drift, person.seed, person.patient)
        save(treatment.thinned(MOMENTS), path)
        progress.advance_to(before + played, f"patient {person.name}")


def save(treatment: Treatment, path: Path) -> None:
    """Write a treatment, wholly or not at all."""
    held = {name: getattr(treatment, name) for name in _OF_TREATMENT}
    shown = {name: getattr(treatment.shown, name, np.empty(0)) for name in _OF_SHOWN}
    save_arrays(path, **held, **shown)


def load(path: Path) -> Treatment:
    """Read a file of ``save``."""
    names = *_OF_TREATMENT, *_OF_SHOWN
    try:
        held = dict(zip(names, load_arrays(path, names, "treatment"), strict=True))
    except InputError as error:
        reason = str(error).removeprefix(f"{path}: ")
        raise InputError(f"{path} is damaged ({reason}); delete it, or use --fresh") from None
    violated, misfit = bool(held.pop("violated")), float(held.pop("misfit"))
    temperature, *reasons = (held.pop(name) for name in _OF_SHOWN)
    shown = Shown(float(temperature), *reasons) if temperature.size else None
    return Treatment(**held, violated=violated, misfit=misfit, shown=shown)
