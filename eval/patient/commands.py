"""The commands ``python -m eval patient`` and ``diagnose``."""

from __future__ import annotations

import shlex
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from eval.options import (
    Believed,
    Changes,
    Cohort,
    Control,
    Effects,
    Fresh,
    Output,
    Patients,
    Seed,
    Sensors,
    Trust,
    fields_of,
)
from eval.report import words
from jawenv.controls import DEFAULT_CONTROL
from jawenv.errors import InputError
from jawenv.files import atomic_write
from jawenv.seeds import REPORTS


def patient_command(
    entry: Annotated[
        str, typer.Argument(metavar="MANEUVER|FILE|RUN", help="A name, a maneuver file or a training run.")
    ],
    patient: Annotated[
        list[Path] | None,
        typer.Option(help="File of a patient; may be repeated. Drawn from the cohort by default.", metavar="FILE"),
    ] = None,
    patients: Annotated[int, typer.Option(help="How many are drawn; one page each.", metavar="N")] = 1,
    treatments: Annotated[
        int, typer.Option(help="One after the other; each begins with what the last has left known.", metavar="N")
    ] = 1,
    drift: Annotated[
        float,
        typer.Option(
            help="How much the muscles change from one treatment to the next: sd of the natural logs, 0.02 is 2 %.",
            metavar="SD",
        ),
    ] = 0.0,
    show_truth: Annotated[
        bool, typer.Option("--show-truth", help="Show the true values of the simulated patient as well.")
    ] = False,
    env: Annotated[
        str | None, typer.Option(help="Environment with six muscles: Jaw or JawBilateral.", metavar="NAME")
    ] = None,
    cohort: Cohort = "trismus",
    seed: Seed = REPORTS[0].start,
    control: Control = DEFAULT_CONTROL,
    sensors: Sensors = "pose",
    episode_s: Annotated[float, typer.Option(help="Length of every treatment, s.", metavar="S")] = 30.0,
    reality: Effects = None,
    device: Changes = None,
    estimator: Believed = None,
    output: Output = Path("runs/patient"),
    fresh: Fresh = False,
    trust: Trust = False,
) -> None:
    """Treat one patient or a few, and write for each a page that says which muscles are stiff and how sure that is.

    Writes patient-NAME.html, which prints on one sheet, and verdicts.parquet. Ctrl-C keeps the treatments that are
    over: the same command goes on from there.
    """
    import pandas as pd

    from eval.entries import env_of_runs, load_entries
    from eval.patient import page
    from eval.patient.courses import persons, play_courses
    from eval.patient.treatments import Course
    from eval.settings import Settings
    from eval.tables import made_with, write_table

    plan = Course(treatments, drift)
    effects = fields_of("reality", reality, "creep_share=0.3")
    changed = fields_of("device", device, "cell_force_N=0.2")
    settings = Settings(
        1, cohort, seed, control, sensors, episode_s, env or env_of_runs([entry]), effects, changed, estimator
    )
    page.check_env(settings.env)
    people = persons(seed, patients, patient or [])
    (loaded,) = load_entries([entry], settings.env_kwargs, settings.env, trust=trust)
    console = _console()
    courses = play_courses(loaded, plan, people, output, fresh=fresh, console=console)
    about = made_with(_command(), settings=asdict(settings), course=asdict(plan), entry=loaded.about())
    rows = [row for person, course in zip(people, courses, strict=True) for row in page.verdict_rows(person, course)]
    write_table(pd.DataFrame(rows), output / "verdicts.parquet", about)
    for person, course in zip(people, courses, strict=True):
        text = page.render(loaded, person, plan, course, about, show_truth)
        written = page.write(text, output / f"patient-{person.name}.html")
        said = {str(row["muscle"]): str(row["verdict"]) for row in page.verdict_rows(person, course[-1:])}
        console.print(f"{written}: {page.headline(said)}", soft_wrap=True)
    console.print(f"verdicts: {output / 'verdicts.parquet'}", soft_wrap=True)


def diagnose_command(
    entries: Annotated[
        list[str] | None,
        typer.Argument(metavar="MANEUVER|FILE|RUN|MODULE:NAME...", help="Names, maneuver files or training runs."),
    ] = None,
    env: Annotated[
        str | None, typer.Option(help="Environment; that of the trained runs by default.", metavar="NAME")
    ] = None,
    patients: Patients = 200,
    cohort: Cohort = "one_sided",
    seed: Seed = REPORTS[0].start,
    control: Control = DEFAULT_CONTROL,
    sensors: Sensors = "pose",
    episode_s: Annotated[float, typer.Option(help="Length of every treatment, s.", metavar="S")] = 30.0,
    reality: Effects = None,
    device: Changes = None,
    estimator: Believed = None,
    output: Output = Path("runs/diagnose"),
    fresh: Fresh = False,
    trust: Trust = False,
) -> None:
    """Say how often the verdicts of one treatment are right, over a cohort: sensitivity, specificity, and both errors.

    Writes diagnosis.md, diagnosis.parquet, and the tables of ``compare``. Ctrl-C keeps the entries that are finished:
    the same command goes on from there.
    """
    from eval.comparison.compare import compare
    from eval.entries import env_of_runs, load_entries
    from eval.patient import accuracy
    from eval.settings import Settings
    from eval.tables import write_table

    wanted = entries or []
    if not wanted:
        raise InputError("nothing to diagnose with: name a maneuver or a training run")
    effects = fields_of("reality", reality, "creep_share=0.3")
    changed = fields_of("device", device, "cell_force_N=0.2")
    settings = Settings(
        patients, cohort, seed, control, sensors, episode_s, env or env_of_runs(wanted), effects, changed, estimator
    )
    loaded, console = load_entries(wanted, settings.env_kwargs, settings.env, trust=trust), _console()
    study = compare(loaded, settings, output, command=_command(), fresh=fresh, console=console)
    table = accuracy.accuracy(study)
    write_table(table, output / "diagnosis.parquet", study.about)
    lead = (
        f"`{_command()}`: {patients} patients of the cohort {words.label(cohort)}, seeds {seed} to "
        f"{seed + patients - 1}, {episode_s:g} s, {control} control."
    )
    with atomic_write(output / "diagnosis.md") as unfinished:
        unfinished.write_text(accuracy.markdown(table, lead), encoding="utf-8")
    accuracy.show(table, console)
    console.print(accuracy.NOTE, style="dim")
    console.print(f"table:   {output / 'diagnosis.md'}\nresults: {output / 'diagnosis.parquet'}", soft_wrap=True)


def _command() -> str:
    return shlex.join(["python", "-m", "eval", *sys.argv[1:]])


def _console() -> Console:
    """A terminal of its own width, or a log wide enough for the tables."""
    return Console(highlight=False, width=None if sys.stdout.isatty() else 120)
