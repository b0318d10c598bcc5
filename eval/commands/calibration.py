"""The command ``python -m eval calibrate``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from eval.commands import options
from eval.commands.options import terminal, typed
from jawenv.base.errors import InputError
from jawenv.base.files import write_text


@options.takes_world("episode_s")
@options.takes_together
def _calibrate_command(
    world: dict[str, Any],
    entries: Annotated[
        list[str] | None, typer.Argument(metavar="MANEUVER|FILE|RUN|MODULE:NAME...", help=options.ENTRIES)
    ] = None,
    filters: Annotated[
        str,
        typer.Option(
            help="tension (the environment's own), ekf-decaying, ekf-constant, ekf-none, ekf-linear; separated by "
            "commas.",
            metavar="NAME,...",
        ),
    ] = "tension",
    times: Annotated[
        str, typer.Option(help="When beliefs are judged, s; the last ends the episode.", metavar="S,...")
    ] = "10,30,60",
    played: options.Played = options.Played(Path("runs/calibrate"), 200),
) -> None:
    """Say whether filters are calibrated: whether the truth lies where they claim, on all cores.

    Writes beliefs.parquet (one row per patient, filter and time), calibration.parquet and calibration.md. Ctrl-C keeps
    the chunks of patients that are finished: the same command goes on from there.
    """
    from eval.calibration import summary
    from eval.calibration.cells import cells_of
    from eval.kept.cells import play_cells
    from eval.kept.entries import Settings
    from eval.kept.parts import Run
    from eval.kept.tables import made_with, write_table

    moments = tuple(_seconds(text) for text in times.split(","))
    names = tuple(name.strip() for name in filters.split(","))
    output, console = played.output, terminal()
    settings = Settings.of(played.patients, played.seed, **world | {"episode_s": moments[-1]})
    cells = cells_of(list(dict.fromkeys(entries or [])), names, moments, settings, trust=played.trust)
    rows = play_cells(cells, output, Run(played.fresh, console=console), "estimates")
    table = summary.summarise(rows)
    metadata = made_with(typed(), settings=settings.to_mapping(), filters=names, times=moments)
    write_table(rows, output / "beliefs.parquet", metadata)
    write_table(table, output / "calibration.parquet", metadata)
    write_text(output / "calibration.md", summary.markdown(table, f"`{typed()}`"))
    summary.show(table, console)
    console.print(
        f"table:   {output / 'calibration.md'}\n"
        f"results: {output / 'calibration.parquet'}, {output / 'beliefs.parquet'}",
        soft_wrap=True,
    )


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"times is {text.strip()!r}; allowed: seconds separated by commas, as 10,30") from None
