"""A study from start to end: what is missing is played on all cores, and every part is kept once it is finished.

A part is some patients of one cell. Patient i is drawn, and its noise made, by the seed ``seed + i``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import pandas as pd

from eval.comparison import results
from eval.kept.parts import Part, Run, finish, folder_for, parts_of
from eval.kept.tables import read_table, write_table
from eval.studies.cells import FACTORS, Cell, cells_of
from eval.studies.design import Design
from jawenv.progress import Progress

PATIENTS_IN_A_PART = 20
PATIENTS_OF_A_PLANNER = 4
_NEEDED = ("seed", *results.PATIENT_METRICS)
_BOUNDS = {"information_bound", "worst_bound_sd"}


def play_study(design: Design, output: Path, run: Run | None = None, *, trust: bool = False) -> pd.DataFrame:
    """Play all cells of a study.

    Args:
        design: the study.
        output: folder; its ``parts`` holds what is finished.
        run: how it is played.
        trust: whether checkpoints that lie in no run's folder may be unpickled.

    Returns:
        One row per cell and patient: the columns of `FACTORS`, and those of `eval.comparison.results`.

    Raises:
        InputError: an entry that cannot be played, an output folder that cannot be used, or a kept file that is
            damaged.
    """
    cells = {_name(cell): cell for cell in cells_of(design, trust)}
    bound = not _BOUNDS.isdisjoint(design.metrics)
    folder = folder_for(output, "parts")
    parts = {name: _parts_of(name, cell, folder, bound) for name, cell in cells.items()}
    every = [part for of_cell in parts.values() for part in of_cell]
    kept = finish(every, partial(play_part, cells=cells, bound=bound), _read, "episodes", run)
    tables = {name: pd.concat([kept[path] for part in parts[name] for _, path in part.files]) for name in cells}
    return pd.concat([_placed(tables[name], cell) for name, cell in cells.items()], ignore_index=True)


def play_part(part: Part, progress: Progress, cells: Mapping[str, Cell], bound: bool) -> None:
    """Play some patients of one cell and keep their rows.

    Args:
        part: ``first`` is the seed of the first patient.
        progress: counts episodes.
        cells: of the study, by their names.
        bound: whether the posterior Cramer-Rao bound is computed.
    """
    entry = cells[part.key].load()
    recording = entry.play(part.number, part.first, track_bound=bound)
    rows = results.from_recording(recording, entry.label, part.first, {}).patients
    for _, path in part.files:
        write_table(rows, path, {"cell": part.key})


def _name(cell: Cell) -> str:
    return " · ".join(f"{level:g} Hz" if isinstance(level, float) else level for level in cell.levels)


def _parts_of(name: str, cell: Cell, folder: Path, bound: bool) -> list[Part]:
    first, size = cell.settings.seed, PATIENTS_OF_A_PLANNER if cell.planned else PATIENTS_IN_A_PART
    seeds = range(first, first + cell.settings.patients)
    return parts_of(name, seeds, size, folder, {cell.entry: cell.fingerprint(bound)})


def _read(path: Path) -> pd.DataFrame:
    return read_table(path, _NEEDED)[0]


def _placed(rows: pd.DataFrame, cell: Cell) -> pd.DataFrame:
    """The rows of a cell, and before them what tells it apart."""
    rows = rows.assign(patient=rows["seed"] - cell.settings.seed).drop(columns="entry")
    for place, (factor, level) in enumerate(zip(FACTORS, cell.levels, strict=True)):
        rows.insert(place, factor, level)
    return rows
