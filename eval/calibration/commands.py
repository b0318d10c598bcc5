"""The command ``python -m eval calibrate``."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from eval import options
from eval.terminal import terminal, typed
from jawenv.controls import DEFAULT_CONTROL
from jawenv.errors import InputError
from jawenv.files import write_text
from jawenv.seeds import REPORTS


def calibrate_command(
    entries: Annotated[
        list[str] | None, typer.Argument(metavar="MANEUVER|FILE|RUN|MODULE:NAME...", help=options.ENTRIES)
    ] = None,
    filters: Annotated[
        str,
        typer.Option(
            help="tension (the environment's own), ekf-decaying, ekf-constant, ekf-none, ekf-linear, ekf-filterpy, "
            "mode-search, smoother, ukf (slow); separated by commas.",
            metavar="NAME,...",
        ),
    ] = "tension",
    patients: options.Patients = 200,
    seed: options.Seed = REPORTS[0].start,
    cohort: options.Cohort = "trismus",
    control: options.Control = DEFAULT_CONTROL,
    sensors: options.Sensors = "pose",
    env: options.EnvironmentOrJaw = "Jaw",
    times: Annotated[
        str, typer.Option(help="When beliefs are judged, s; the last ends the episode.", metavar="S,...")
    ] = "10,30,60",
    reality: options.Effects = None,
    device: options.Changes = None,
    estimator: options.Believed = None,
    knowledge: options.Known = "exact",
    comfort: options.Comfort = None,
    anatomy: options.Anatomy = None,
    force_sensor: options.ForceSensor = "cell",
    output: options.Output = Path("runs/calibrate"),
    details: options.Details = False,
    fresh: options.Fresh = False,
    trust: options.Trust = False,
) -> None:
    """Say whether filters are honest: whether the truth lies where they claim, on all cores.

    Writes beliefs.parquet (one row per patient, filter and time), calibration.parquet and calibration.md. Ctrl-C keeps
    the chunks of patients that are finished: the same command goes on from there.
    """
    from eval.calibration import summary
    from eval.calibration.calibrate import Calibration, calibrate
    from eval.kept.parts import Run
    from eval.kept.tables import made_with, write_table
    from eval.settings import Settings

    moments = tuple(_seconds(text) for text in times.split(","))
    world = options.world(reality, device, estimator, knowledge, comfort, anatomy, force_sensor)
    settings = Settings(patients, cohort, seed, control, sensors, moments[-1], env, **world)
    wanted = Calibration(settings, tuple(name.strip() for name in filters.split(",")), moments)
    specs, console = list(dict.fromkeys(entries or [])), terminal()
    rows = calibrate(specs, wanted, output, Run(fresh, console=console), trust=trust)
    table, about = summary.summarise(rows), made_with(typed(), calibration=asdict(wanted))
    write_table(rows, output / "beliefs.parquet", about)
    write_table(table, output / "calibration.parquet", about)
    write_text(output / "calibration.md", summary.markdown(table, f"`{typed()}`"))
    summary.show(table, console, details=details)
    console.print(
        f"table:   {output / 'calibration.md'}\n"
        f"results: {output / 'calibration.parquet'}, {output / 'beliefs.parquet'}",
        soft_wrap=True,
    )


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"times: {text.strip()!r} given, allowed are seconds separated by commas, as 10,30") from None
