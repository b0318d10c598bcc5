"""Courses of treatments of some patients, each treatment kept on disk as soon as it is over."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from rich.console import Console

from agents.array_files import load_arrays, save_arrays
from eval.chunks import folder_for
from eval.entries import Entry, fingerprint
from eval.patient import belief, cohort, treatments
from eval.patient.treatments import Course, Treatment, first_treatment, next_treatment
from jawenv.anatomy import Patient
from jawenv.errors import InputError
from jawenv.locks import alone
from jawenv.progress import Progress

MOMENTS = 40
"""Kept of each treatment."""


@dataclass(frozen=True)
class Person:
    """Whom a course is played on.

    Attributes:
        name: for the page and its file.
        seed: of the patient, the noise and the drift.
        patient: given by a file; drawn from the cohort by default.
    """

    name: str
    seed: int
    patient: Patient | None = None


def persons(seed: int, number: int, files: Sequence[Path] = ()) -> list[Person]:
    """The patients of some files, or those that a cohort has at seeds that follow each other.

    Args:
        seed: of the first one.
        number: how many are drawn where no file is given.
        files: of patients.

    Raises:
        InputError: a number is not allowed, a file is damaged, or two would write the same page.
    """
    if number < 1:
        raise InputError(f"patients: {number} given, allowed is 1 or more")
    if seed < 0:
        raise InputError(f"seed: {seed} given, allowed is 0 or more")
    if not files:
        return [Person(str(seed + i), seed + i) for i in range(number)]
    given = [Person(path.stem, seed + i, Patient.load(path)) for i, path in enumerate(files)]
    for i, person in enumerate(given):
        if person.name in [earlier.name for earlier in given[:i]]:
            raise InputError(f"patient: {files[i]} given beside another file of that name; allowed are other names")
    return given


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
        output: folder; its ``treatments`` holds what is over, and an interrupted course goes on there.
        fresh: play again what the folder holds.
        console: where progress is shown; nowhere by default.

    Returns:
        The treatments of each patient, at some of their times.

    Raises:
        InputError: the folder cannot be used or is in use, a kept file is damaged, or what the environment refuses.
    """
    folder = folder_for(output, "treatments")
    progress = Progress(len(people) * course.number, "treatments", console or Console(quiet=True))
    with alone(folder), progress:
        progress.say(f"playing {int(progress.total)} treatments")
        return [_play_course(entry, course, person, folder, fresh, progress) for person in people]


def _play_course(
    entry: Entry, course: Course, person: Person, folder: Path, fresh: bool, progress: Progress
) -> list[Treatment]:
    """Play a course on one patient, or what is missing of it."""
    key = fingerprint(
        entry,
        {
            "seed": person.seed,
            "drift": course.drift,
            "patient": None if person.patient is None else person.patient.model_dump(),
            "moments": MOMENTS,
            "program": _digest(),
        },
    )
    course_so_far: list[Treatment] = []
    for number in range(1, course.number + 1):
        path = folder / f"{key}-{number:04d}.npz"
        if path.exists() and not fresh:
            course_so_far.append(load(path))
            progress.skip(1)
            continue
        if not course_so_far:
            played = first_treatment(entry, person.seed, person.patient)
        else:
            played = next_treatment(entry, course_so_far[-1], number, course.drift, person.seed, person.patient)
        course_so_far.append(played.thinned(MOMENTS))
        save(course_so_far[-1], path)
        progress.advance_to(progress.done + 1, f"patient {person.name}")
    return course_so_far


def _digest() -> str:
    """Changes with the sources that make treatments (jawenv and the agents are in the entry's fingerprint)."""
    sources = [Path(str(module.__file__)).read_bytes() for module in (belief, cohort, treatments)]
    return hashlib.sha256(b"".join(sources)).hexdigest()[:16]


def save(treatment: Treatment, path: Path) -> None:
    """Write a treatment, wholly or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    save_arrays(path, **asdict(treatment))


def load(path: Path) -> Treatment:
    """Read what ``save`` has written.

    Raises:
        InputError: the file is damaged.
    """
    names = tuple(field.name for field in fields(Treatment))
    try:
        held = dict(zip(names, load_arrays(path, names, "treatment"), strict=True))
    except InputError as error:
        reason = str(error).removeprefix(f"{path}: ")
        raise InputError(f"{path} is damaged ({reason}); delete it, or use --fresh") from None
    violated = bool(held.pop("violated"))
    return Treatment(**held, violated=violated)
