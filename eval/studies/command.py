"""What ``python -m eval study`` does with a study: plays it, and writes and prints its results."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import get_args

from rich.console import Console

from eval.chunks import Backend
from eval.studies import design, drawing, estimates, tables
from eval.studies.run import play_study
from eval.tables import git_state, machine, made_with, write_table
from jawenv.errors import InputError, shown
from jawenv.files import atomic_write

OUTPUT = Path("runs/study")
PATIENTS = "patients.parquet"


@dataclass(frozen=True)
class Asked:
    """The arguments of the command.

    Attributes:
        study: name or file.
        patients: fewer than the study has; None for all.
        output: folder of the results; None for one of the study's name.
        fresh: play again what the folder holds.
        workers: processes; None for all cores.
        backend: of the processes, see `eval.chunks.finish`.
        trust: whether checkpoints that lie in no run's folder may be unpickled.
    """

    study: str
    patients: int | None
    output: Path | None
    fresh: bool
    workers: int | None
    backend: str
    trust: bool = False


def study(asked: Asked, command: str, console: Console) -> None:
    """Play a study and write `study.md`, `profiles.svg`, and the Parquet files of patients, cells, pairs and profiles.

    Args:
        asked: the arguments.
        command: how they were given, for the results.
        console: where progress and the table are shown.

    Raises:
        InputError: a study or backend that does not exist or does not fit, or files that cannot be read or written.
    """
    if asked.backend not in get_args(Backend):
        raise InputError(f"backend: {shown(asked.backend)} given, allowed are {', '.join(get_args(Backend))}")
    backend: Backend = "ray" if asked.backend == "ray" else "loky"
    name, wanted = design.read(asked.study)
    if asked.patients is not None:
        wanted = wanted.model_copy(update={"patients": min(asked.patients, wanted.patients)})
    output = asked.output or OUTPUT / name
    rows = play_study(
        wanted, output, fresh=asked.fresh, trust=asked.trust, workers=asked.workers, backend=backend, console=console
    )
    about = made_with(command, study=wanted.model_dump(mode="json"), git=git_state(), machine=machine())
    write_table(rows, output / PATIENTS, about)
    console.print("estimating figures, pairs and profiles with their intervals")
    figures = {
        "cells": estimates.cells(rows, wanted),
        "pairs": estimates.pairs(rows, wanted),
        "profiles": estimates.profiles(rows, wanted),
    }
    for each, table in figures.items():
        write_table(table, output / f"{each}.parquet", about)
    page = tables.markdown(figures["cells"], figures["pairs"], figures["profiles"], wanted, about)
    with atomic_write(output / "study.md") as unfinished:
        unfinished.write_text(page, encoding="utf-8")
    drawing.draw(figures["profiles"], wanted, output / "profiles.svg")
    tables.show(figures["cells"], wanted, console)
    console.print(f"tables:  {output / 'study.md'}\nfigure:  {output / 'profiles.svg'}", soft_wrap=True)
    console.print(f"results: {output / PATIENTS}, and cells, pairs, profiles beside it", soft_wrap=True)
