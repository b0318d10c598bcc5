"""The command ``python -m eval benchmark``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from eval import options
from eval.terminal import terminal, typed
from jawenv.errors import InputError

if TYPE_CHECKING:
    from eval.kept.parts import Run


def benchmark_command(
    agents: Annotated[
        list[str] | None, typer.Argument(metavar="[MANEUVER|FILE|RUN|MODULE:NAME]...", help=options.ENTRIES)
    ] = None,
    tasks: Annotated[
        str | None, typer.Option(help="Some tasks, with commas between; all by default.", metavar="NAME,...")
    ] = None,
    known: Annotated[bool, typer.Option("--list", help="Say which tasks there are.")] = False,
    check: Annotated[
        Path | None, typer.Option("--check", help="Play a submission again, in place of agents.", metavar="FOLDER")
    ] = None,
    patients: Annotated[
        int | None,
        typer.Option(
            help="The first of every task, to try it out; with --check so many, drawn in tens.", metavar="N", min=1
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of that draw.", metavar="N", min=0)] = 0,
    output: options.Output = Path("runs/benchmark"),
    fresh: options.Fresh = False,
    workers: Annotated[int | None, typer.Option(help="Processes; all cores by default.", metavar="N", min=1)] = None,
    trust: options.Trust = False,
) -> None:
    """Play the tasks of the frozen benchmark, and write a submission that anyone can check (docs/benchmark.md).

    Writes benchmark.md, benchmark.parquet, submission.json and copies of the agents' files. Ctrl-C keeps what is
    finished: the same command goes on from there.
    """
    from eval.benchmark.tasks import tasks_named
    from eval.kept.parts import Run

    wanted = None if tasks is None else [name.strip() for name in tasks.split(",") if name.strip()]
    run = Run(fresh, workers, console=terminal())
    if known:
        for task in tasks_named(wanted):
            print(f"{task.id:20s} {task.description}")
    elif check is not None:
        if agents or tasks is not None:
            raise InputError("--check: plays what the submission names; allowed beside it: --patients, --seed")
        _check(check, patients, seed, run, trust)
    else:
        _play(agents or [], wanted, patients, output, run, trust)


def _play(
    agents: list[str], wanted: list[str] | None, patients: int | None, output: Path, run: Run, trust: bool
) -> None:
    from eval.benchmark import submission, tables
    from eval.benchmark.run import cells_of, play_cells
    from eval.benchmark.tasks import tasks_named
    from eval.kept.tables import made_with, write_table
    from jawenv.files import write_json, write_text
    from jawenv.locks import alone

    submission.refuse_copies(agents, output)
    cells = cells_of(agents, tasks_named(wanted), trust=trust)
    rows = play_cells(cells, output, patients, run)
    about = made_with(typed())
    with alone(output):
        kept = submission.keep_agents(cells, output)
        write_table(rows, output / submission.PATIENTS, about)
        write_text(output / submission.PAGE, tables.markdown(rows, about))
        write_json(output / submission.FILE, submission.make(cells, rows, kept, about))
    console = terminal()
    tables.show(rows, console)
    console.print(f"tables:     {output / submission.PAGE}\nsubmission: {output / submission.FILE}", soft_wrap=True)


def _check(folder: Path, patients: int | None, seed: int, run: Run, trust: bool) -> None:
    from eval.benchmark.check import check

    found = check(folder, patients, seed, run, trust=trust)
    if found.faults:
        more = f" (and {len(found.faults) - 1} more)" if len(found.faults) > 1 else ""
        raise InputError(f"{folder} does not reproduce: {found.faults[0]}{more}")
    print(f"{folder} reproduces: {found.played} episodes played again, {found.equal} with the same score to the digit")
