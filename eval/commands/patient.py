"""The command ``python -m eval patient``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from eval.commands import options
from eval.commands.options import terminal, typed
from jawenv.base.seeds import REPORTS
from jawenv.ladder import DEFAULT_ENV, env_id_of

CLINIC = {"cohort": "anyone", "knowledge": "bench"}  # in jawenv/Jaw; elsewhere the environment's own knowledge


@options.takes_world(defaults=CLINIC)
def _patient_command(
    world: dict[str, Any],
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
    seed: options.Seed = REPORTS[0].start,
    output: options.Output = Path("runs/patient"),
    trust: options.Trust = False,
) -> None:
    """Treat one patient or a few, and write for each a page on stiff muscles and their certainty.

    Writes patient-NAME.html, which prints on one sheet, and verdicts.parquet.
    """
    import pandas as pd

    from eval.kept.entries import Settings, env_of_runs, load_entries
    from eval.kept.parts import folder_for
    from eval.kept.tables import made_with, write_table
    from eval.patient import page
    from eval.patient.courses import persons, play_courses
    from eval.patient.treatments import Course, population_of
    from eval.report import template
    from jawenv.anatomy import MUSCLE_NAMES

    plan = Course(treatments, drift)
    settings = Settings.of(1, seed, **as_a_clinic({"env": env_of_runs([entry])} | world))
    page.check_env(settings.world.env_id)
    people = persons(seed, patients, patient or [])
    (loaded,) = load_entries([entry], settings.world, trust=trust)
    console = terminal()
    folder_for(output, ".")
    courses = play_courses(loaded, plan, people, console)
    metadata = made_with(typed(), settings=settings.to_mapping(), course=asdict(plan), entry=loaded.about())
    prior = population_of(loaded).prior
    rows = [
        row for person, course in zip(people, courses, strict=True) for row in page.verdict_rows(person, course, prior)
    ]
    write_table(pd.DataFrame(rows), output / "verdicts.parquet", metadata)
    for person, course in zip(people, courses, strict=True):
        subject = page.Subject.simulated(loaded, person, plan, float(course[-1].time[-1]))
        text = page.render(subject, course, metadata, show_truth)
        written = template.write(text, output / f"patient-{person.name}.html")
        now = page.verdicts_of(course, prior)
        verdict_words = {name: verdict.word for name, verdict in zip(MUSCLE_NAMES, now, strict=True)}
        console.print(f"{written}: {page.headline(verdict_words)}", soft_wrap=True)
    console.print(f"verdicts: {output / 'verdicts.parquet'}", soft_wrap=True)


def as_a_clinic(world: dict[str, Any]) -> dict[str, Any]:
    """Arguments of a world of whose patient nothing is known: a cohort that is named stays, an exact anatomy too."""
    reference = env_id_of(world["env"]) == DEFAULT_ENV
    return {name: value for name, value in CLINIC.items() if name == "cohort" or reference} | world
