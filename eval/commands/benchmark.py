"""The command ``python -m eval benchmark``."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Annotated

import typer

from eval.commands import options
from eval.commands.options import terminal, typed

BASELINES = (
    "hold_still",
    "random",
    "slow_opening",
    "universal",
    "refined",
    "refined_imaged",
    "refined_one_sided",
    "apg_asked",
    "ppo_trismus",
    "apg_imaged",
    "apg_anyone",
)
"""Agents of the table of docs/tables/benchmark.md."""
PATIENTS, PAGE = "benchmark.parquet", "benchmark.md"


def _benchmark_command(
    agents: Annotated[
        list[str] | None,
        typer.Argument(metavar="[MANEUVER|FILE|RUN|MODULE:NAME]...", help=f"{options.ENTRIES} All baselines if none."),
    ] = None,
    tasks: Annotated[
        str | None, typer.Option(help="Some tasks, with commas between; all by default.", metavar="NAME,...")
    ] = None,
    listing: Annotated[bool, typer.Option("--list", help="Say which tasks there are.")] = False,
    patients: Annotated[
        int | None, typer.Option(help="The first of every task, to try it out.", metavar="N", min=1)
    ] = None,
    key: Annotated[
        str, typer.Option(help="Draw the same other patients again; drawn anew by default.", metavar="KEY")
    ] = "",
    output: options.Output = Path("runs/benchmark"),
    fresh: options.Fresh = False,
    workers: options.Workers = None,
    trust: options.Trust = False,
) -> None:
    """Play the tasks of the frozen benchmark, and write their scores (docs/studies.md).

    Every task is played with its own patients, and with as many whom a new key draws. Writes benchmark.md and
    benchmark.parquet. Ctrl-C keeps what is finished: the same command, with --key, goes on from there.
    """
    from eval.benchmark.run import cells_of, fitting_agents, left_out
    from eval.benchmark.tables import check_table, markdown, score_table
    from eval.benchmark.tasks import tasks_named
    from eval.kept.cells import play_cells
    from eval.kept.parts import Run
    from eval.kept.tables import made_with, write_table
    from jawenv.base.files import write_text
    from jawenv.base.locks import alone

    names = None if tasks is None else [name.strip() for name in tasks.split(",") if name.strip()]
    chosen, console = tasks_named(names), terminal()
    if listing:
        for task in chosen:
            print(f"{task.id:20s} {task.description}")
        return
    key = key or secrets.token_hex(16)
    cells = cells_of(agents or fitting_agents(BASELINES, chosen), chosen, key, patients, trust=trust)
    for line in left_out(cells, chosen):
        console.print(line, soft_wrap=True)
    console.print(f"other patients: --key {key}", soft_wrap=True)
    rows = play_cells(cells, output, Run(fresh, workers, console=console))
    metadata = made_with(typed())
    with alone(output):
        write_table(rows, output / PATIENTS, metadata)
        write_text(output / PAGE, markdown(rows, metadata, key))
    score_table(rows).show(console)
    check_table(rows).show(console)
    console.print(f"tables: {output / PAGE}", soft_wrap=True)
