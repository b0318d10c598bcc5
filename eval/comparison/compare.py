"""A comparison: a study of one world, in which every entry meets the same patients with the same noise."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from eval.comparison import results
from eval.comparison.results import Results
from eval.kept.cells import Cell, play_cells
from eval.kept.entries import Entry
from eval.kept.parts import Run
from eval.kept.settings import Settings
from eval.kept.tables import made_with
from eval.rows.outcomes import Outcomes
from jawenv.errors import InputError
from jawenv.locks import alone


def compare(
    entries: Sequence[Entry],
    settings: Settings,
    output: Path | None = None,
    *,
    command: str = "",
    fresh: bool = False,
    console: Console | None = None,
) -> Results:
    """Play every entry on the same patients and noise; keep each as soon as it is finished.

    Args:
        entries: the contestants.
        settings: on whom and how.
        output: folder for `patients.parquet`, `curves.parquet` and what is kept, which is used again when nothing that
            decides it has changed; without a folder nothing is kept.
        command: how the user asked for it, for the results' metadata.
        fresh: compute every entry again.
        console: where progress is shown; nowhere by default.

    Returns:
        The tables of the comparison, as saved.

    Raises:
        InputError: no entry, or one of another environment than the settings'; the output folder cannot be used or
            another process uses it, or a kept file is damaged.
    """
    if not entries:
        raise InputError("nothing to compare: name a maneuver or a training run, or use --all-maneuvers")
    for entry in entries:
        if entry.env_id != settings.world.env_id:
            raise InputError(f"{entry.label} plays {entry.env_id}, but this comparison is in {settings.world.env_id}")
    with TemporaryDirectory() if output is None else nullcontext(output) as folder, alone(Path(folder)):
        # All patients of an entry together: threads share them out, and a yoked replay knows its patient by the place.
        seeds, outcomes = settings.seeds, Outcomes()
        cells = [
            Cell({"entry": entry.label}, partial(_itself, entry), seeds, outcomes, len(seeds)) for entry in entries
        ]
        rows = play_cells(cells, Path(folder), Run(fresh, 1, console=console))
        metadata = made_with(command, settings=settings.to_mapping(), entries=[entry.about() for entry in entries])
        study = Results.of_rows(rows, metadata)
        if output is not None:
            results.save(study, output)
    return study


def _itself(entry: Entry) -> Entry:
    return entry
