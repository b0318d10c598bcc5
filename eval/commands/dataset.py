"""The command ``python -m eval dataset``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from eval.commands import options
from eval.commands.options import terminal, typed


@options.takes_world()
@options.takes_together
def _dataset_command(
    world: dict[str, Any],
    entries: Annotated[
        list[str] | None,
        typer.Argument(metavar="[MANEUVER|FILE|RUN|MODULE:NAME]...", help=options.ENTRIES + " Five by default."),
    ] = None,
    file_format: Annotated[
        str, typer.Option("--format", help="arrow, or hdf5, which needs h5py.", metavar="NAME")
    ] = "arrow",
    played: options.Played = options.Played(Path("runs/dataset")),
    croissant: Annotated[
        bool, typer.Option("--croissant", help="Describe each for machines too: croissant.json, core and RAI.")
    ] = False,
) -> None:
    """Write episodes as data sets of Minari, one for each entry (docs/benchmark.md#reference-episodes).

    MINARI_DATASETS_PATH=FOLDER makes minari.load_dataset find them. Without names these are random, hold_still,
    slow_opening, opening_with_swings_and_fore_aft and refined.
    """
    from eval.episodes.dataset import FORMATS, REFERENCES, Form, write_all
    from eval.kept.entries import Settings
    from jawenv.base.errors import InputError, shown

    if file_format not in FORMATS:
        raise InputError(f"format is {shown(file_format)}; allowed: {', '.join(FORMATS)}")
    settings = Settings.of(played.patients, played.seed, **world)
    console, output = terminal(), played.output
    asked, form = entries or list(REFERENCES), Form(file_format, croissant)
    names = write_all(asked, settings, output, form, typed(), console, fresh=played.fresh, trust=played.trust)
    for name in names:
        console.print(f"{output / name}", soft_wrap=True)
