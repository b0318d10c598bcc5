"""The command ``python -m eval information``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from eval.commands import options
from eval.commands.options import terminal, typed


@options.takes_world()
@options.takes_together
def _information_command(
    world: dict[str, Any],
    entries: Annotated[
        list[str] | None, typer.Argument(metavar="MANEUVER|FILE|RUN|MODULE:NAME...", help=options.ENTRIES)
    ] = None,
    contrasts: Annotated[
        int, typer.Option(help="Of each record, each a likelihood; 0 leaves the bound of the belief.", metavar="N")
    ] = 64,
    played: options.Played = options.Played(Path("runs/information"), 100),
    workers: options.Workers = None,
) -> None:
    """Bound the expected information gain of designs and policies, in nats with standard errors (docs/inference.md).

    Episodes last 10 s unless --episode-s says otherwise.

    Writes information.md, information.parquet and patients.parquet. Ctrl-C keeps the patients that are finished: the
    same command goes on from there.
    """
    from eval.comparison import information
    from eval.kept.cells import play_cells
    from eval.kept.entries import Settings
    from eval.kept.parts import Run
    from eval.kept.tables import made_with, write_table
    from jawenv.base.files import write_text

    output, console = played.output, terminal()
    settings = Settings.of(played.patients, played.seed, **{"episode_s": 10.0} | world)
    cells = information.cells_of(list(dict.fromkeys(entries or [])), settings, contrasts, trust=played.trust)
    rows = play_cells(cells, output, Run(played.fresh, workers, console=console), "records")
    metadata = made_with(typed(), settings=settings.to_mapping(), contrasts=contrasts)
    summary = information.summarise(rows)
    table = information.table(summary)
    write_table(rows, output / "patients.parquet", metadata)
    write_table(summary, output / "information.parquet", metadata)
    write_text(output / "information.md", f"Made by `{metadata['command']}`.\n\n{table.markdown()}\n")
    table.show(console)
    console.print(f"table: {output / 'information.md'}", soft_wrap=True)
