"""The command ``python -m eval benchmark``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from eval.commands import options
from eval.commands.options import terminal, typed
from jawenv.base.errors import InputError, shown

if TYPE_CHECKING:
    import pandas as pd

    from eval.kept.parts import Run

TABLE = Path(__file__).parents[2] / "docs" / "tables" / "benchmark.md"
BASELINES = (
    "hold_still",
    "random",
    "slow_opening",
    "opening_with_swings_and_fore_aft",
    "refined",
    "refined_imaged",
    "refined_one_sided",
    "apg_asked",
    "ppo_trismus",
    "ppo_force",
    "apg_imaged",
    "apg_anyone",
)


def _benchmark_command(
    agents: Annotated[
        list[str] | None, typer.Argument(metavar="[MANEUVER|FILE|RUN|MODULE:NAME]...", help=options.ENTRIES)
    ] = None,
    tasks: Annotated[
        str | None, typer.Option(help="Some tasks, with commas between; all by default.", metavar="NAME,...")
    ] = None,
    listing: Annotated[bool, typer.Option("--list", help="Say which tasks there are.")] = False,
    check: Annotated[
        Path | None, typer.Option("--check", help="Play a submission again, in place of agents.", metavar="FOLDER")
    ] = None,
    patients: Annotated[
        int | None,
        typer.Option(
            help="The first of every task, to try it out; with --check so many of every score, drawn.",
            metavar="N",
            min=1,
        ),
    ] = None,
    baselines: Annotated[
        bool,
        typer.Option(
            "--baselines",
            help="Play what comes with jawenv; of all tasks and patients also renews docs/tables/benchmark.md.",
        ),
    ] = False,
    output: options.Output = Path("runs/benchmark"),
    fresh: options.Fresh = False,
    workers: options.Workers = None,
    backend: options.Backend = "loky",
    trust: options.Trust = False,
    fresh_seeds: Annotated[
        int | None,
        typer.Option(
            help="With --check: also play the agents and a maneuver on so many patients whom nobody could know.",
            metavar="N",
            min=2,
        ),
    ] = None,
    key: Annotated[
        str | None,
        typer.Option(
            help="By which --fresh-seeds draws, as an earlier check said it; drawn by default.", metavar="HEX"
        ),
    ] = None,
) -> None:
    """Play the tasks of the frozen benchmark, and write a submission that anyone can check (docs/benchmark.md).

    Writes benchmark.md, benchmark.parquet, submission.json and copies of the agents' files. Ctrl-C keeps what is
    finished: the same command goes on from there.
    """
    from eval.benchmark.tasks import tasks_named
    from eval.kept.parts import Backend, Run

    names = None if tasks is None else [name.strip() for name in tasks.split(",") if name.strip()]
    run = Run(fresh, workers, cast(Backend, backend), terminal())
    if listing:
        for task in tasks_named(names):
            print(f"{task.id:20s} {task.description}")
    elif check is not None:
        if agents or tasks is not None:
            raise InputError(
                "--check: plays what the submission names; allowed beside it: --patients, --fresh-seeds, --key, --trust"
            )
        _check(check, patients, run, trust, fresh_seeds, key)
    elif fresh_seeds is not None or key is not None:
        raise InputError("--fresh-seeds and --key: belong to --check")
    elif baselines:
        _play_baselines(agents or [], names, patients, output, run)
    else:
        _play(agents or [], names, patients, output, run, trust)


def _play(
    agents: list[str], names: list[str] | None, patients: int | None, output: Path, run: Run, trust: bool
) -> None:
    from eval.benchmark import submission, tables
    from eval.benchmark.run import cells_of, left_out
    from eval.benchmark.tasks import tasks_named
    from eval.kept.cells import play_cells
    from eval.kept.tables import made_with, write_table
    from jawenv.base.files import write_json, write_text
    from jawenv.base.locks import alone

    submission.refuse_copies(agents, output)
    submission.refuse_answers(agents)
    tasks, console = tasks_named(names), terminal()
    cells = cells_of(agents, tasks, patients, trust=trust)
    for line in left_out(cells, tasks):
        console.print(line, soft_wrap=True)
    rows = play_cells(cells, output, run)
    metadata = made_with(typed())
    with alone(output):
        submitted = submission.keep_agents({str(cell.levels["agent"]): cell.load().spec for cell in cells}, output)
        write_table(rows, output / submission.PATIENTS, metadata)
        write_text(output / submission.PAGE, tables.markdown(rows, metadata))
        write_json(output / submission.FILE, submission.make(cells, rows, submitted, metadata))
    tables.score_table(rows).show(console)
    console.print(f"tables:     {output / submission.PAGE}\nsubmission: {output / submission.FILE}", soft_wrap=True)


def _play_baselines(agents: list[str], names: list[str] | None, patients: int | None, output: Path, run: Run) -> None:
    """Play the agents of jawenv; all patients of all tasks, at a commit without changes, renew the page."""
    from eval.benchmark.run import fitting_agents
    from eval.benchmark.submission import PAGE
    from eval.benchmark.tasks import tasks_named
    from jawenv.base.files import write_text
    from jawenv.base.reading import read_text
    from jawenv.base.versions import made_with

    if agents:
        raise InputError(f"--baselines: plays what comes with jawenv, and not {shown(agents[0])}; allowed: no agents")
    if names is not None or patients is not None:
        _play(fitting_agents(BASELINES, tasks_named(names)), names, patients, output, run, False)
        return
    git = made_with()["git"]
    if git is None or git["changed"]:
        raise InputError("--baselines: files differ from the commit; allowed: a clone without changes")
    _play(list(BASELINES), None, None, output, run, False)
    write_text(TABLE, read_text(output / PAGE))


def _check(folder: Path, patients: int | None, run: Run, trust: bool, fresh_seeds: int | None, key: str | None) -> None:
    from eval.benchmark.check import CANNOT_KNOW, check
    from eval.benchmark.differences import LARGEST_SHARE
    from eval.benchmark.fresh import CHECKED
    from eval.benchmark.scores import by_cell, score_of
    from eval.benchmark.tasks import TASKS
    from eval.figures.words import with_interval

    drawn_by = _key_of(key)
    result = check(folder, patients, run, trust=trust)
    if result.faults:
        more = f" (and {len(result.faults) - 1} more)" if len(result.faults) > 1 else ""
        raise InputError(f"{folder} does not reproduce: {result.faults[0]}{more}")
    print(
        f"{folder} reproduces: {result.played} episodes played again, {result.equal} with the same score to the digit"
    )
    how = "to the bit" if result.exact else f"within a control step and {100 * LARGEST_SHARE:g} %, on another platform"
    print(f"compared: every column, {how}")
    whole = min(task.patients for task in TASKS.values())
    trial = (
        "" if result.patients >= whole else f"the first {result.patients} of {whole}, which is no whole submission; "
    )
    print(f"patients: {trial}{_drawn(patients, result.patients)}")
    for (task, agent), rows in by_cell(result.rows).items():
        print(f"score: {task}, {agent}: {with_interval(score_of(rows), 2)} s")
    for line in CANNOT_KNOW:
        print(f"not known: {line}")
    if fresh_seeds is not None:
        _check_fresh(folder, result.rows, fresh_seeds, drawn_by, run, trust)
    elif (folder / CHECKED).exists():
        print(f"not checked: {folder / CHECKED}, which anybody can have written; --fresh-seeds N makes it anew")


def _drawn(patients: int | None, available: int) -> str:
    """The chance that a check finds forged patients."""
    if patients is None or patients >= available:
        return "all were played"
    from scipy.stats import hypergeom

    forged = -(-available // 10)
    missed = 100 * hypergeom(available, forged, patients).pmf(0)
    return f"{patients} were drawn: {forged} forged ones of a score stay unseen with a chance of {missed:.2g} % at most"


def _key_of(key: str | None) -> bytes:
    import secrets

    try:
        return secrets.token_bytes(32) if key is None else bytes.fromhex(key)
    except ValueError:
        raise InputError(f"--key is {shown(key)}; allowed: hexadecimal digits") from None


def _check_fresh(folder: Path, public: pd.DataFrame, number: int, key: bytes, run: Run, trust: bool) -> None:
    """Compare public with fresh patients, and keep the scores beside the submission."""
    from eval.benchmark import fresh, submission
    from eval.figures.words import scaled, with_interval
    from eval.kept.tables import made_with
    from jawenv.base.files import write_json

    compared = fresh.compare(folder, submission.read(folder), public, number, key, run, trust=trust)
    print(f"fresh patients: {number} of each task, drawn by --key {key.hex()}")
    for one in compared:
        known, new, apart = (with_interval(figure, 2, " s") for figure in (one.public, one.fresh, one.apart))
        its = " and ".join(with_interval(score, 2, " s") for score in one.maneuver)
        print(f"{one.task}, {one.agent}: public {known}, fresh {new}, difference {apart}; {fresh.MANEUVER} {its}")
        longer = with_interval(scaled(one.worse, 100.0), 0, " %")
        print(f"  beside {fresh.MANEUVER} longer on fresh patients by {longer}; by chance so much in {one.chance:.2g}")
    if found := fresh.suspected(compared):
        (folder / fresh.CHECKED).unlink(missing_ok=True)  # one that came along does not outlive the refusal
        names = ", ".join(f"{one.task}, {one.agent}" for one in found)
        raise InputError(f"{folder}: better on public patients than on fresh ones by more than chance: {names}")
    write_json(folder / fresh.CHECKED, fresh.written(compared, folder, number, key, made_with(typed())))
    print(f"scores that count: {folder / fresh.CHECKED}")
