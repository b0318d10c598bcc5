"""The command line ``jawenv``: ``live``, ``score``, ``identify``, ``import`` and ``list``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from jawenv.base.seeds import REPORTS
from jawenv.commands import options
from jawenv.commands.running import command_line, run

app = command_line("Drive a simulated jaw, play and score maneuvers, identify muscles from a recording.")


OPENS_WITH = {"cohort": "one_sided"}  # whose stiff side pulls the jaw aside: there is something to see


@app.command("live")
@options.takes_world(defaults=OPENS_WITH)
def _live_command(
    world: dict[str, Any],
    recording: Annotated[
        Path | None, typer.Argument(metavar="[RECORDING]", help="Play this .csv or .parquet in place of a drive.")
    ] = None,
    port: Annotated[int, typer.Option(help="Of the page on this machine; 0 takes a free one.", metavar="N")] = 8090,
    driver: Annotated[
        str, typer.Option(help="Who drives at first: you, a maneuver, a policy, or its file or folder.", metavar="NAME")
    ] = "you",
    seed: options.Seed = REPORTS[0].start,
    output: Annotated[Path, typer.Option(help="Folder where drives are saved.", metavar="FOLDER")] = Path("runs/live"),
    open_browser: Annotated[bool, typer.Option("--open", help="Open the page in a browser.")] = False,
) -> None:
    """Drive the jaw of a patient by hand, on a page of this machine (docs/live.md). Ctrl-C ends it."""
    from jawenv.commands.live import drive, play_back
    from jawenv.envs.configuration import Configuration
    from jawenv.live.setup import Setup

    if recording is not None:
        play_back(recording, port, open_browser)
    else:
        drive(
            Setup(Configuration.from_mapping(OPENS_WITH | world), seed),
            driver,
            port,
            output,
            open_browser,
        )


@app.command("score")
@options.takes_world(otherwise="; a policy's own")
def _score_command(
    maneuver: options.Maneuver,
    world: dict[str, Any],
    patients: Annotated[int, typer.Option(help="How many.", metavar="N")] = 16,
    seed: options.Seed = REPORTS[0].start,
) -> None:
    """Play a maneuver or a policy on simulated patients; say what it finds out, and whether that can be believed."""
    from jawenv.commands.maneuvers import print_score, world_for

    print_score(maneuver, patients, seed, world_for(maneuver, world))


@app.command("identify")
def _identify_command(
    recordings: Annotated[
        list[Path], typer.Argument(metavar="RECORDING...", help=".csv or .parquet files of one patient.")
    ],
    cohort: options.Cohort = None,
    knowledge: options.Knowledge = None,
    anatomy: options.Anatomy = None,
    head_tilt: options.HeadTilt = None,
    columns: options.Columns = None,
    resample: options.Resample = None,
    before: Annotated[
        Path | None, typer.Option(help="An earlier log of force and opening of the same patient.", metavar="FILE")
    ] = None,
    page: Annotated[
        Path | None, typer.Option(help="Write the patient's page; needs a clone of the project.", metavar="FILE.html")
    ] = None,
    json: Annotated[
        Path | None,
        typer.Option(help="Write all that is found as JSON, - to the terminal, for a program.", metavar="FILE.json"),
    ] = None,
) -> int:
    """Estimate F_o and b of every muscle from a recording, and say whether to believe it (docs/recordings.md).

    Ends with status 3 where the estimates are not to be believed.
    """
    from jawenv.commands.outputs import answering
    from jawenv.commands.recordings import print_answer

    reading = {"cohort": cohort, "knowledge": knowledge, "anatomy": anatomy, "head_tilt_deg": head_tilt}
    reading |= {"columns": columns, "resample_hz": resample, "before": before}
    with answering(json) as output:
        return print_answer(recordings, reading, page, output)


@app.command("doctor")
def _doctor_command(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING", help="A .csv or .parquet file.")],
    cohort: options.Cohort = None,
    columns: options.Columns = None,
    resample: options.Resample = None,
) -> int:
    """Say what is wrong with a bench's recording, and what mends it (docs/recordings.md)."""
    from jawenv.commands.recordings import look_at

    return look_at(recording, {"cohort": cohort, "columns": columns, "resample_hz": resample})


@app.command("suggest")
def _suggest_command(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING", help="A .csv or .parquet file.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Maneuver to record next.", metavar="FILE.yaml")],
    seconds: Annotated[float, typer.Option(help="Its length.", metavar="S")] = 10.0,
    search: Annotated[int, typer.Option(help="Steps of the search from there, 5 s each.", metavar="N")] = 0,
    asked: Annotated[
        str | None, typer.Option(help="Muscle whose error bars count, or a word of several.", metavar="NAME")
    ] = None,
    cohort: options.Cohort = None,
    knowledge: options.Knowledge = None,
    columns: options.Columns = None,
    resample: options.Resample = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an older maneuver.")] = False,
) -> None:
    """Suggest the movement to record next: made for the estimates of this recording (docs/recordings.md)."""
    from jawenv.commands.suggest import suggest_next

    reading = {"cohort": cohort, "knowledge": knowledge, "columns": columns, "resample_hz": resample}
    wanted = {"seconds": seconds, "search": search, "asked": asked}
    suggest_next(recording, output, wanted, reading, overwrite)


@app.command("import")
def _import_command(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="Tracker's .c3d, .trc, .mot, .sto or .h5, or a recording."),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="A recording (.csv), .mot or .sto.", metavar="FILE")],
    forces: Annotated[
        Path | None, typer.Option(help="Load cell's .csv, .mot or .sto, of a clock of its own.", metavar="FILE")
    ] = None,
    landmarks: Annotated[
        Path | None,
        typer.Option(help="Places of incisor, molar_left and molar_right, the jaw closed (TOML).", metavar="FILE"),
    ] = None,
    registered: Annotated[bool, typer.Option("--registered", help="The file is in head axes already.")] = False,
    jaw: Annotated[str | None, typer.Option(help="Body, or markers, on the lower jaw: A,B,C.", metavar="NAMES")] = None,
    head: Annotated[
        str | None, typer.Option(help="Body, or markers, on the head: D,E,F, or fixed.", metavar="NAMES")
    ] = None,
    unit: Annotated[
        str | None, typer.Option(help="Of lengths, in place of what the file states.", metavar="UNIT")
    ] = None,
    offset: Annotated[
        float | None, typer.Option(help="What the clock of the forces shows at 0 of the tracker's.", metavar="SECONDS")
    ] = None,
    columns: Annotated[
        Path | None, typer.Option(help="File with the names, units and signs of the forces.", metavar="FILE")
    ] = None,
    resample: options.Resample = None,
) -> None:
    """Make a recording of a jaw tracker's file and a load cell's (docs/recordings.md#files-of-the-trade)."""
    from jawenv.trackers.importing import ImportSettings, import_file

    settings = ImportSettings(forces, landmarks, registered, jaw, head, unit, offset, columns, resample)
    for line in import_file(file, output, settings):
        print(line)


@app.command("list")
def _list_command(
    what: Annotated[
        str | None, typer.Argument(metavar="[maneuvers|agents|cohorts|models]", help="What to list; all by default.")
    ] = None,
) -> None:
    """Say which maneuvers, agents, cohorts and models there are."""
    from jawenv.commands.listing import print_list

    print_list(what)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Returns:
        Exit code: 0 done, 2 unusable input, 3 a recording that is not to be believed, 130 interrupted.
    """
    return run(app, "jawenv", arguments, "fewer patients, or shorter episodes,")
