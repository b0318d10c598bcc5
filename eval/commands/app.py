"""Commands: ``python -m eval compare``, ``play``, ``patient`` and others, which ``python -m eval`` lists."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from eval.commands import options
from eval.commands.options import terminal, typed
from jawenv.base.errors import InputError
from jawenv.base.seeds import REPORTS
from jawenv.commands.running import command_line, run

INTERRUPTED = 130
MOST_FILMED = 2


@options.takes_world()
def _play_command(
    world: dict[str, Any],
    entries: options.OneOrTwo,
    video: Annotated[
        Path | None, typer.Option(help="Write a film, .mp4 or .webp, in place of opening a window.", metavar="FILE")
    ] = None,
    patient: Annotated[
        Path | None, typer.Option(help="File of the patient; one is drawn from the cohort by default.", metavar="FILE")
    ] = None,
    seed: options.Seed = REPORTS[0].start,
    width: Annotated[int, typer.Option(help="Of the film, pixels.", metavar="N")] = 1280,
    every: Annotated[int, typer.Option(help="Of the control steps one is filmed.", metavar="N")] = 1,
    trust: options.Trust = False,
) -> None:
    """Show one episode in a window, or write it as a film; two are shown beside each other, on the same patient."""
    if len(entries) > MOST_FILMED:
        raise InputError(f"entries is {', '.join(entries)}; allowed: one, or two beside each other")
    if video is None:
        if len(entries) > 1:
            raise InputError("video is none; allowed: a film of two, use --video FILE")
        from jawenv.base.display import check_display

        check_display("a window", "use --video FILE, which writes a film")
    from eval.episodes import film
    from eval.kept.entries import env_of_runs, load_entries
    from jawenv.envs.configuration import Configuration

    asked = Configuration.from_mapping({"env": env_of_runs(entries)} | world)
    loaded, console = load_entries(entries, asked, trust=trust), terminal()
    films = [film.Film(entry, seed, patient, width, every) for entry in loaded]
    summary = film.show(films[0], console) if video is None else film.write(films, video, console)
    console.print(summary + ("" if video is None else f"\nfilm: {video}"), soft_wrap=True)


def _study_command(
    study: Annotated[str | None, typer.Argument(metavar="[NAME|FILE]", help="A study of --list, or a file.")] = None,
    listing: Annotated[bool, typer.Option("--list", help="Say which studies come with the project.")] = False,
    patients: Annotated[
        int | None, typer.Option(help="Fewer than the study has, to try it out.", metavar="N", min=1)
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="Folder of the results; runs/study/NAME by default.", metavar="FOLDER")
    ] = None,
    fresh: options.Fresh = False,
    workers: options.Workers = None,
    trust: options.Trust = False,
) -> None:
    """Play a study's file: every entry under every setting on the same patients, on all cores (docs/studies.md).

    Writes study.md, and patients, cells and pairs as Parquet. Whatever ends a run keeps the parts of some patients that
    are finished: the same command goes on from there.
    """
    from eval.kept.parts import Run
    from eval.studies import command, design

    if listing:
        for name, path in design.shipped().items():
            print(f"{name:14s} {design.read(str(path))[1].title}")
    elif study is None:
        raise InputError(f"study is none; allowed: {', '.join(design.shipped())}, or a file")
    else:
        console = terminal()
        how = Run(fresh, workers, console)
        command.study(study, patients, output, how, typed(), console, trust)


COMMANDS: dict[str, Callable[..., None] | str] = {
    "compare": "eval.commands.comparison",
    "report": "eval.commands.comparison",
    "replay": "eval.commands.comparison",
    "calibrate": "eval.commands.calibration",
    "benchmark": "eval.commands.benchmark",
    "play": _play_command,
    "study": _study_command,
    "patient": "eval.commands.patient",
}
"""Function of each command, or the module that has it."""


def commands(names: Iterable[str] = COMMANDS) -> typer.Typer:
    """The command line of these commands; modules of others are not loaded."""
    app = command_line("Compare maneuvers and trained agents on the same patients.")
    for name in names:
        command = COMMANDS[name]
        if isinstance(command, str):
            command = getattr(import_module(command), f"_{name}_command")
        app.command(name)(command)
    return app


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns:
        Exit code: 0 done, 2 unusable input, 130 interrupted.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    asked = arguments[:1] if arguments and arguments[0] in COMMANDS else COMMANDS
    code = run(commands(asked), "python -m eval", arguments, "fewer patients, or shorter episodes,")
    if code == INTERRUPTED:  # typer catches Ctrl-C itself
        print("interrupted: what is finished is kept, the same command goes on from there", file=sys.stderr)
    return code
