"""``python -m eval study``: plays a study, and writes and prints its results."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from eval.kept.cells import play_cells
from eval.kept.parts import Run
from eval.kept.tables import made_with, write_table
from eval.studies import design, estimates, tables
from eval.studies.grid import FACTORS, cells_of
from jawenv.base.files import write_text
from jawenv.base.locks import alone

OUTPUT = Path("runs/study")
PATIENTS = "patients.parquet"


def study(
    source: str,
    patients: int | None,
    output: Path | None,
    run: Run,
    command: str,
    console: Console,
    trust: bool = False,
) -> None:
    """Play a study and write `study.md`, and the Parquet files of patients, cells and pairs.

    Args:
        source: name or file of the study.
        patients: fewer than the study has; None for all.
        output: folder of the results; None for one of the study's name.
        run: how it is played.
        command: how all this was given, for the results.
        console: where the table is shown.
        trust: whether stable-baselines3 checkpoints may be unpickled.
    """
    name, plan = design.read(source)
    if patients is not None:
        plan = plan.model_copy(update={"patients": min(patients, plan.patients)})
    output, metadata = output or OUTPUT / name, made_with(command, study=plan.model_dump(mode="json"))
    if plan.results:
        from eval.thesis.catalogue import chosen
        from eval.thesis.study import study as thesis

        thesis(chosen(plan.results), plan.patients, plan.seed, output, run, metadata, console)
        return
    rows = play_cells(cells_of(plan, trust), output, run)
    rows.insert(len(FACTORS), "patient", rows["seed"] - plan.seed)
    with alone(output):
        write_table(rows, output / PATIENTS, metadata)
        console.print("estimating figures and pairs with their intervals")
        figures = {
            "cells": estimates.cells(rows, plan),
            "pairs": estimates.pairs(rows, plan),
        }
        for name_of_table, table in figures.items():
            write_table(table, output / f"{name_of_table}.parquet", metadata)
        page = tables.markdown(figures["cells"], figures["pairs"], plan, metadata)
        write_text(output / "study.md", page)
    tables.of_cells(figures["cells"], plan).show(console, intervals=False)
    console.print(f"tables:  {output / 'study.md'}", soft_wrap=True)
    console.print(f"results: {output / PATIENTS}, and cells, pairs beside it", soft_wrap=True)
