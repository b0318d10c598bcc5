"""A study from start to end: what is missing is played on all cores, and every part is kept once it is finished.

A part is some patients of one cell, in a file whose name changes with whatever could change its rows. Patient i is
drawn, and its noise made, by the seed ``seed + i``, so that the rows depend neither on the number of processes nor on
how often a run was interrupted.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import pandas as pd
from rich.console import Console

from eval.chunks import Backend, Chunk, finish, folder_for
from eval.comparison import results
from eval.studies.cells import FACTORS, Cell, cells_of
from eval.studies.design import Design
from eval.tables import read_table, write_table
from jawenv.playing.rollout import play

# Few enough to lose little when interrupted, enough for the vector environment to be quick.
PATIENTS_IN_A_PART = 20
PATIENTS_OF_A_PLANNER = 4
_NEEDED = ("seed", *results.PATIENT_METRICS)
_BOUNDS = {"information_bound", "worst_bound_sd"}


def play_study(
    design: Design,
    output: Path,
    *,
    fresh: bool = False,
    trust: bool = False,
    workers: int | None = None,
    backend: Backend = "loky",
    console: Console | None = None,
) -> pd.DataFrame:
    """Play all cells of a study.

    Args:
        design: the study.
        output: folder; its ``parts`` holds what is finished.
        fresh: play again what the folder holds.
        trust: whether checkpoints that lie in no run's folder may be unpickled.
        workers: processes; all cores by default.
        backend: of the processes, see `eval.chunks.finish`.
        console: where progress is shown; nowhere by default.

    Returns:
        One row per cell and patient: the columns of `FACTORS`, and those of `eval.comparison.results`.

    Raises:
        InputError: an entry that cannot be played, an output folder that cannot be used, or a kept file that is
            damaged.
    """
    cells = cells_of(design, trust)
    bound = not _BOUNDS.isdisjoint(design.metrics)
    folder = folder_for(output, "parts")
    parts = {_name(cell): _parts_of(cell, folder, bound) for cell in cells}
    every = [part for of_cell in parts.values() for part in of_cell]
    if not fresh:
        _check([path for part in every for _, path in part.files if path.exists()])
    work = partial(play_part, cells={_name(cell): cell for cell in cells}, bound=bound)
    finish(every, work, "episodes", fresh=fresh, workers=workers, backend=backend, console=console)
    return pd.concat([_rows_of(cell, parts[_name(cell)]) for cell in cells], ignore_index=True)


def play_part(part: Chunk, cells: Mapping[str, Cell], bound: bool) -> None:
    """Play some patients of one cell and keep their rows.

    Args:
        part: ``first`` is the seed of the first patient.
        cells: of the study, by their names.
        bound: whether the posterior Cramer-Rao bound is computed.
    """
    entry = cells[part.key].load()
    recording = play(
        entry.agent,
        patients=part.number,
        seed=part.first,
        env_kwargs=entry.env_kwargs | {"track_bound": bound},
        env_id=entry.env_id,
    )
    rows = results.from_recording(recording, entry.label, part.first, {}).patients
    for _, path in part.files:
        write_table(rows, path, {"cell": part.key})


def _name(cell: Cell) -> str:
    return " · ".join(f"{level:g} Hz" if isinstance(level, float) else level for level in cell.levels)


def _parts_of(cell: Cell, folder: Path, bound: bool) -> list[Chunk]:
    settings = cell.settings
    key = hashlib.sha256(f"{cell.fingerprint()} {bound} {_digest()}".encode()).hexdigest()[:16]
    size = PATIENTS_OF_A_PLANNER if cell.planned else PATIENTS_IN_A_PART
    parts = []
    for first in range(settings.seed, settings.seed + settings.patients, size):
        number = min(size, settings.seed + settings.patients - first)
        path = folder / f"{cell.entry}-{first:05d}-{number}-{key}.parquet".replace("/", "_")
        parts.append(Chunk(_name(cell), first, number, (("rows", path),)))
    return parts


def _digest() -> str:
    """Changes with the source that makes the rows (those of jawenv and the agents are in the cell's fingerprint)."""
    return hashlib.sha256(Path(str(results.__file__)).read_bytes()).hexdigest()[:16]


def _check(paths: Sequence[Path]) -> None:
    """Read what is kept before anything is played, so that damage is found at once.

    Raises:
        InputError: a file is damaged.
    """
    for path in paths:
        read_table(path, _NEEDED)


def _rows_of(cell: Cell, parts: Sequence[Chunk]) -> pd.DataFrame:
    """The rows of a cell, and before them what tells it apart."""
    rows = pd.concat([read_table(path, _NEEDED)[0] for part in parts for _, path in part.files], ignore_index=True)
    rows = rows.assign(patient=rows["seed"] - cell.settings.seed).drop(columns="entry")
    for place, (factor, level) in enumerate(zip(FACTORS, cell.levels, strict=True)):
        rows.insert(place, factor, level)
    return rows
