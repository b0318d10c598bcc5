"""Commands: ``python -m eval compare``, ``play``, ``patient`` and others, which ``python -m eval`` lists."""

from __future__ import annotations

import os
import shlex
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from eval.options import (
    Believed,
    Changes,
    Cohort,
    Control,
    Effects,
    Fresh,
    LargestDiscomfort,
    LargestViolation,
    Output,
    Patients,
    Reference,
    Seed,
    Sensors,
    fields_of,
)
from eval.patient.commands import diagnose_command, patient_command
from jawenv.errors import InputError, out_of_memory
from jawenv.files import atomic_write
from jawenv.seeds import REPLAYS, REPORTS
from training.help import Commands

if TYPE_CHECKING:
    from eval.comparison.admission import Admission
    from eval.comparison.results import Results

INTERRUPTED = 130
QUICK_DRAWS = 4
_ENTRIES_HELP = "Names, maneuver files, training runs, exported policies, or agents of your own as package.module:Name."

app = typer.Typer(
    cls=Commands,
    name="python -m eval",
    help="Compare maneuvers and trained agents on the same patients; draw the thesis's results again.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.callback()
def _root() -> None:
    """Compare maneuvers and trained agents on the same patients."""


@app.command("compare")
def compare_command(
    entries: Annotated[
        list[str] | None,
        typer.Argument(metavar="[MANEUVER|FILE|RUN|MODULE:NAME]...", help=_ENTRIES_HELP),
    ] = None,
    all_maneuvers: Annotated[
        bool, typer.Option("--all-maneuvers", help="Add every hand-made maneuver and the random policy.")
    ] = False,
    env: Annotated[
        str | None,
        typer.Option(
            help="Environment: jawenv/JawSides-v1, or JawSides, or sides; that of the trained runs by default.",
            metavar="NAME",
        ),
    ] = None,
    patients: Patients = 64,
    cohort: Cohort = "trismus",
    seed: Seed = REPORTS[0].start,
    control: Control = "force",
    sensors: Sensors = "pose",
    episode_s: Annotated[float, typer.Option(help="Length of every episode, s.", metavar="S")] = 30.0,
    reality: Effects = None,
    device: Changes = None,
    estimator: Believed = None,
    reference: Reference = None,
    largest_discomfort_s: LargestDiscomfort = 0.1,
    largest_violation: LargestViolation = 0.01,
    with_replay: Annotated[
        bool,
        typer.Option(
            "--with-replay",
            help="Add what each trained or planned entry does on average over other patients, replayed without "
            "looking: an entry that adapts to its patient does better.",
        ),
    ] = False,
    output: Output = Path("runs/compare"),
    fresh: Fresh = False,
) -> None:
    """Play every entry on the same patients with the same noise, rank them and write a report.

    Ranked is what is within comfort, by the time until all parameters are known to 5 %. Writes report.html,
    patients.parquet and curves.parquet. Ctrl-C keeps the entries that are finished: the same command goes on from
    there.
    """
    from eval.comparison.admission import Admission
    from eval.comparison.compare import compare
    from eval.entries import env_of_runs, load_entries, maneuver_names, warn_of_pickles
    from eval.settings import Settings

    admission = Admission(largest_discomfort_s, largest_violation)
    wanted = [*(entries or []), *(maneuver_names() if all_maneuvers else [])]
    effects = fields_of("reality", reality, "creep_share=0.3")
    changed = fields_of("device", device, "cell_force_N=0.2")
    settings = Settings(
        patients, cohort, seed, control, sensors, episode_s, env or env_of_runs(wanted), effects, changed, estimator
    )
    warn_of_pickles(wanted)
    loaded = load_entries(wanted, settings.env_kwargs, settings.env)
    if reference is not None and reference not in [entry.label for entry in loaded]:
        allowed = ", ".join(entry.label for entry in loaded)
        raise InputError(f"reference: {reference!r} given, allowed are {allowed}")
    console = _console()
    if with_replay:
        from eval.replays import add_replays

        loaded = add_replays(loaded, settings, output / "replays", fresh=fresh, console=console)
    command = shlex.join(["python", "-m", "eval", *sys.argv[1:]])
    study = compare(loaded, settings, output, command=command, fresh=fresh, console=console)
    _present(study, output, reference, admission, console)


@app.command("play")
def play_command(
    entry: Annotated[
        str, typer.Argument(metavar="MANEUVER|FILE|RUN", help="A name, a maneuver file or a training run.")
    ],
    video: Annotated[
        Path | None, typer.Option(help="Write a film, .mp4 or .gif, in place of opening a window.", metavar="FILE")
    ] = None,
    env: Annotated[
        str | None, typer.Option(help="Environment: jawenv/JawSides-v1, or JawSides, or sides.", metavar="NAME")
    ] = None,
    cohort: Cohort = "trismus",
    patient: Annotated[
        Path | None, typer.Option(help="File of the patient; one is drawn from the cohort by default.", metavar="FILE")
    ] = None,
    seed: Seed = REPORTS[0].start,
    control: Control = "trajectory",
    sensors: Sensors = "pose",
    episode_s: Annotated[float, typer.Option(help="Length of the episode, s.", metavar="S")] = 30.0,
    start_s: Annotated[float, typer.Option(help="Where the film begins, s.", metavar="S")] = 0.0,
    width: Annotated[int, typer.Option(help="Of the film, pixels.", metavar="N")] = 1280,
    every: Annotated[int, typer.Option(help="Of the control steps one is filmed.", metavar="N")] = 1,
) -> None:
    """Show one episode in a window, or write it as a film."""
    from eval import film
    from eval.entries import env_of_runs, load_entries
    from eval.settings import Settings

    settings = Settings(1, cohort, seed, control, sensors, episode_s, env or env_of_runs([entry]))
    (loaded,) = load_entries([entry], settings.env_kwargs, settings.env)
    wanted, console = film.Film(loaded, seed, patient, start_s, width, every), _console()
    said = film.show(wanted, console) if video is None else film.write(wanted, video, console)
    console.print(said + ("" if video is None else f"\nfilm: {video}"), soft_wrap=True)


@app.command("replay")
def replay_command(
    agent: Annotated[str, typer.Argument(metavar="AGENT", help="A planner, a training run or any other entry.")],
    output: Annotated[Path, typer.Option(help="Maneuver file to write.", metavar="FILE.yaml")],
    patients: Patients = 64,
    cohort: Cohort = "trismus",
    seed: Seed = REPLAYS.start,
    sensors: Sensors = "pose",
    episode_s: Annotated[float, typer.Option(help="Length of every episode, s.", metavar="S")] = 30.0,
    env: Annotated[
        str, typer.Option(help="Environment: jawenv/JawSides-v1, or JawSides, or sides.", metavar="NAME")
    ] = "Jaw",
) -> None:
    """Write what an agent does in targets control, averaged over patients, as a maneuver file.

    The maneuver is the agent without its eyes: what the agent does better on other patients, it owes to adapting.
    """
    from eval.entries import load_entries
    from eval.replays import replay_of_entry
    from eval.settings import Settings

    settings = Settings(patients, cohort, seed, "targets", sensors, episode_s, env)
    entry = load_entries([agent], settings.env_kwargs, settings.env)[0]
    replay_of_entry(entry, settings, output, _console())
    print(f"maneuver: {output}")


@app.command("report")
def report_command(
    folder: Annotated[Path, typer.Argument(help="Folder of a finished comparison.", metavar="FOLDER")],
    reference: Reference = None,
    largest_discomfort_s: LargestDiscomfort = 0.1,
    largest_violation: LargestViolation = 0.01,
) -> None:
    """Print the tables of a finished comparison and write its report again."""
    from eval.comparison import results
    from eval.comparison.admission import Admission

    admission = Admission(largest_discomfort_s, largest_violation)
    _present(results.load(folder), folder, reference, admission, _console())


@app.command("card")
def card_command(
    folder: Annotated[Path, typer.Argument(help="Folder of a finished comparison.", metavar="FOLDER")],
    entry: Annotated[str, typer.Argument(help="Whose figures: an entry of the comparison.", metavar="ENTRY")],
    output: Annotated[Path, typer.Option(help="The file to write, a .json.", metavar="FILE")] = Path(
        "runs/results.json"
    ),
) -> None:
    """Write what an entry reached in a comparison, for the model card that `training export --results` makes."""
    from eval.comparison import results
    from eval.comparison.card_results import card_results
    from jawenv.files import write_json

    reached = card_results(results.load(folder), entry)
    write_json(output, reached)
    for result in reached.results:
        kind, value = ("mean", result.mean) if result.median is None else ("median", result.median)
        print(f"{result.metric}: {kind} {value:g} ({result.low:g} … {result.high:g})")
    print(f"written: {output}")


@app.command("calibrate")
def calibrate_command(
    entries: Annotated[
        list[str] | None, typer.Argument(metavar="MANEUVER|FILE|RUN|MODULE:NAME...", help=_ENTRIES_HELP)
    ] = None,
    filters: Annotated[
        str,
        typer.Option(
            help="tension (the environment's own), ekf-decaying, ekf-constant, ekf-none, ekf-linear, ekf-filterpy, "
            "mode-search, smoother, ukf (slow); separated by commas.",
            metavar="NAME,...",
        ),
    ] = "tension",
    patients: Patients = 200,
    seed: Seed = REPORTS[0].start,
    cohort: Cohort = "trismus",
    control: Control = "force",
    sensors: Sensors = "pose",
    env: Annotated[
        str, typer.Option(help="Environment: jawenv/JawSides-v1, or JawSides, or sides.", metavar="NAME")
    ] = "Jaw",
    times: Annotated[
        str, typer.Option(help="When beliefs are judged, s; the last ends the episode.", metavar="S,...")
    ] = "10,30,60",
    reality: Effects = None,
    device: Changes = None,
    estimator: Believed = None,
    output: Output = Path("runs/calibrate"),
    fresh: Fresh = False,
) -> None:
    """Say whether filters are honest: whether the truth lies where they claim, on all cores.

    Writes beliefs.parquet (one row per patient, filter and time), calibration.parquet and calibration.md. Ctrl-C keeps
    the chunks of patients that are finished: the same command goes on from there.
    """
    from eval.calibration import summary
    from eval.calibration.calibrate import Calibration, calibrate
    from eval.entries import warn_of_pickles
    from eval.settings import Settings
    from eval.tables import made_with, write_table

    command = shlex.join(["python", "-m", "eval", *sys.argv[1:]])
    moments = tuple(_seconds(text) for text in times.split(","))
    effects = fields_of("reality", reality, "creep_share=0.3")
    changed = fields_of("device", device, "cell_force_N=0.2")
    settings = Settings(patients, cohort, seed, control, sensors, moments[-1], env, effects, changed, estimator)
    wanted = Calibration(settings, tuple(name.strip() for name in filters.split(",")), moments)
    specs, console = list(dict.fromkeys(entries or [])), _console()
    warn_of_pickles(specs)
    rows = calibrate(specs, wanted, output, fresh=fresh, console=console)
    table, about = summary.summarise(rows), made_with(command, calibration=asdict(wanted))
    write_table(rows, output / "beliefs.parquet", about)
    write_table(table, output / "calibration.parquet", about)
    with atomic_write(output / "calibration.md") as unfinished:
        unfinished.write_text(summary.markdown(table, f"`{command}`"), encoding="utf-8")
    summary.show(table, console)
    console.print(
        f"table:   {output / 'calibration.md'}\n"
        f"results: {output / 'calibration.parquet'}, {output / 'beliefs.parquet'}",
        soft_wrap=True,
    )


@app.command("study")
def study_command(
    study: Annotated[str | None, typer.Argument(metavar="[NAME|FILE]", help="A study of --list, or a file.")] = None,
    known: Annotated[bool, typer.Option("--list", help="Say which studies come with the project.")] = False,
    patients: Annotated[
        int | None, typer.Option(help="Fewer than the study has, to try it out.", metavar="N", min=1)
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Folder of the results; runs/study/NAME by default.", metavar="FOLDER")
    ] = None,
    fresh: Fresh = False,
    workers: Annotated[int | None, typer.Option(help="Processes; all cores by default.", metavar="N", min=1)] = None,
    backend: Annotated[
        str, typer.Option(help="loky, this machine; ray, the cluster that RAY_ADDRESS names.", metavar="NAME")
    ] = "loky",
) -> None:
    """Play a study's file: every entry under every setting on the same patients, on all cores (docs/studies.md).

    Writes study.md, profiles.svg, and patients, cells, pairs and profiles as Parquet. Whatever ends a run keeps
    the parts of some patients that are finished: the same command goes on from there.
    """
    from eval.studies import command, design

    if known:
        for name, path in design.shipped().items():
            print(f"{name:12s} {design.read(str(path))[1].title}")
    elif study is None:
        raise InputError(f"study: none given; allowed: {', '.join(design.shipped())}, or a file")
    else:
        asked = command.Asked(study, patients, output, fresh, workers, backend)
        command.study(asked, shlex.join(["python", "-m", "eval", *sys.argv[1:]]), _console())


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"times: {text.strip()!r} given, allowed are seconds separated by commas, as 10,30") from None


@app.command("thesis")
def thesis_command(
    draws: Annotated[int, typer.Option(help="Of each result; the thesis has 1,000.", metavar="N")] = 1000,
    only: Annotated[
        list[str] | None, typer.Option(help="One result by its name, as ekf_sides; may be repeated.", metavar="ITEM")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of all draws.", metavar="N")] = 0,
    output: Output = Path("runs/thesis"),
    fresh: Fresh = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="Short episodes and few cases, to try it out; at most 4 draws.")
    ] = False,
) -> None:
    """Put the results of Young (2016) beside what the corrected equations give, on all cores.

    Writes report.html, and a Parquet and a JSON file per result. 100 draws take up to ten minutes on two cores, 1,000
    ten times as long; the first run compiles for some minutes before. Fewer than 20 get no verdict. Ctrl-C keeps the
    draws that are finished: the same command goes on from there.
    """
    from eval.thesis.study import study

    command = shlex.join(["python", "-m", "eval", *sys.argv[1:]])
    study(only, min(draws, QUICK_DRAWS) if quick else draws, seed, quick, output, fresh, command, _console())


app.command("patient")(patient_command)
app.command("diagnose")(diagnose_command)


def _present(study: Results, output: Path, reference: str | None, admission: Admission, console: Console) -> None:
    from eval.comparison.adaptation import adaptations
    from eval.comparison.ranking import rank
    from eval.report import page, table

    ranking = rank(study, reference, admission)
    table.show(ranking, console)
    table.show_adaptations(adaptations(study), console)
    if not console.is_terminal:
        console.print("drawing the report")
    with console.status("drawing the report"):
        written = page.write(study, ranking, output / "report.html")
    console.print(
        f"report:  {written}\nresults: {output / 'patients.parquet'}, {output / 'curves.parquet'}",
        soft_wrap=True,
    )


class _Console(Console):
    """A console that goes on in silence when its reader has left, as ``head`` does: the results are still written."""

    def on_broken_pipe(self) -> None:
        """See rich."""
        self.quiet = True
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _console() -> Console:
    """A terminal of its own width, or a log wide enough for the tables."""
    return _Console(highlight=False, width=None if sys.stdout.isatty() else 120)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns:
        Exit code: 0 done, 2 unusable input, 130 interrupted.
    """
    try:
        code = int(app(arguments, prog_name="python -m eval", standalone_mode=False) or 0)
        if code == INTERRUPTED:  # typer catches Ctrl-C itself
            print("interrupted: what is finished is kept, the same command goes on from there", file=sys.stderr)
        return code
    except InputError as error:
        message = str(error)
    except MemoryError as error:
        message = f"{out_of_memory(error)}; fewer patients, or shorter episodes, need less"
    except typer.TyperException as error:
        message = error.format_message()
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    return 2
