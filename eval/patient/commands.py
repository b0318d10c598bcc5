"""The commands ``python -m eval patient`` and ``diagnose``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from eval import options
from eval.report import words
from eval.terminal import terminal, typed
from jawenv.controls import DEFAULT_CONTROL
from jawenv.errors import InputError
from jawenv.files import write_text
from jawenv.seeds import REPORTS


def patient_command(
    entry: options.Entry,
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
    cohort: options.Cohort = "trismus",
    seed: options.Seed = REPORTS[0].start,
    control: options.Control = DEFAULT_CONTROL,
    sensors: options.Sensors = "pose",
    episode_s: options.EpisodeS = 30.0,
    reality: options.Effects = None,
    device: options.Changes = None,
    estimator: options.Believed = None,
    knowledge: options.Known = "exact",
    comfort: options.Comfort = None,
    anatomy: options.Anatomy = None,
    force_sensor: options.ForceSensor = "cell",
    output: options.Output = Path("runs/patient"),
    fresh: options.Fresh = False,
    trust: options.Trust = False,
) -> None:
    """Treat one patient or a few, and write for each a page that says which muscles are stiff and how sure that is.

    Writes patient-NAME.html, which prints on one sheet, and verdicts.parquet. Ctrl-C keeps the treatments that are
    over: the same command goes on from there.
    """
    import pandas as pd

    from eval.entries import env_of_runs, load_entries
    from eval.kept.tables import made_with, write_table
    from eval.patient import page
    from eval.patient.courses import persons, play_courses
    from eval.patient.treatments import Course, population_of
    from eval.settings import Settings
    from jawenv.anatomy import MUSCLE_NAMES

    plan = Course(treatments, drift)
    env = env or env_of_runs([entry])
    world = options.world(reality, device, estimator, knowledge, comfort, anatomy, force_sensor)
    settings = Settings(1, cohort, seed, control, sensors, episode_s, env, **world)
    page.check_env(settings.env)
    people = persons(seed, patients, patient or [])
    (loaded,) = load_entries([entry], settings.env_kwargs, settings.env, trust=trust)
    console = terminal()
    courses = play_courses(loaded, plan, people, output, fresh=fresh, console=console)
    about = made_with(typed(), settings=asdict(settings), course=asdict(plan), entry=loaded.about())
    prior = population_of(loaded).prior
    rows = [row for each in zip(people, courses, strict=True) for row in page.verdict_rows(*each, prior)]
    write_table(pd.DataFrame(rows), output / "verdicts.parquet", about)
    for person, course in zip(people, courses, strict=True):
        subject = page.Subject.simulated(loaded, person, plan, float(course[-1].time[-1]))
        text = page.render(subject, course, about, show_truth)
        written = page.write(text, output / f"patient-{person.name}.html")
        said = {name: each.word for name, each in zip(MUSCLE_NAMES, page.said_of(course), strict=True)}
        console.print(f"{written}: {page.headline(said)}", soft_wrap=True)
    console.print(f"verdicts: {output / 'verdicts.parquet'}", soft_wrap=True)


def diagnose_command(
    entries: Annotated[
        list[str] | None,
        typer.Argument(metavar="MANEUVER|FILE|RUN|MODULE:NAME...", help="Names, maneuver files or training runs."),
    ] = None,
    env: options.Environment = None,
    patients: options.Patients = 200,
    cohort: options.Cohort = "one_sided",
    seed: options.Seed = REPORTS[0].start,
    control: options.Control = DEFAULT_CONTROL,
    sensors: options.Sensors = "pose",
    episode_s: options.EpisodeS = 30.0,
    reality: options.Effects = None,
    device: options.Changes = None,
    estimator: options.Believed = None,
    knowledge: options.Known = "exact",
    comfort: options.Comfort = None,
    anatomy: options.Anatomy = None,
    force_sensor: options.ForceSensor = "cell",
    output: options.Output = Path("runs/diagnose"),
    fresh: options.Fresh = False,
    trust: options.Trust = False,
) -> None:
    """Say how often the verdicts of one treatment are right, over a cohort: sensitivity, specificity, and both errors.

    Writes diagnosis.md, diagnosis.parquet, and the tables of ``compare``. Ctrl-C keeps the entries that are finished:
    the same command goes on from there.
    """
    from eval.comparison.compare import compare
    from eval.entries import env_of_runs, load_entries
    from eval.kept.tables import write_table
    from eval.patient import accuracy
    from eval.settings import Settings

    wanted = entries or []
    if not wanted:
        raise InputError("nothing to diagnose with: name a maneuver or a training run")
    env = env or env_of_runs(wanted)
    world = options.world(reality, device, estimator, knowledge, comfort, anatomy, force_sensor)
    settings = Settings(patients, cohort, seed, control, sensors, episode_s, env, **world)
    loaded, console = load_entries(wanted, settings.env_kwargs, settings.env, trust=trust), terminal()
    study = compare(loaded, settings, output, command=typed(), fresh=fresh, console=console)
    table = accuracy.accuracy(study)
    write_table(table, output / "diagnosis.parquet", study.about)
    lead = (
        f"`{typed()}`: {patients} patients of the cohort {words.label(cohort)}, seeds {seed} to "
        f"{seed + patients - 1}, {episode_s:g} s, {control} control."
    )
    write_text(output / "diagnosis.md", accuracy.markdown(table, lead))
    accuracy.show(table, console)
    console.print(accuracy.NOTE, style="dim")
    console.print(f"table:   {output / 'diagnosis.md'}\nresults: {output / 'diagnosis.parquet'}", soft_wrap=True)
