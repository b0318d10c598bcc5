"""The engine of every question of ``eval``: cells are played in parts, kept, found again, and joined to one table.

A cell is an entry in a world, on some patients, and what is kept of each of them. Patient i is drawn, and its noise
made, by the seed of its number, so that a row is the same whatever else is played.
"""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import pandas as pd

from eval.kept.digest import digest, fingerprint
from eval.kept.entries import Entry
from eval.kept.parts import Part, Run, finish, folder_for
from eval.kept.tables import read_table, write_table
from jawenv.base.progress import Progress

FOLDER = "parts"
"""Folder of finished parts within an output folder."""


@dataclass(frozen=True)
class Rows(ABC):
    """A family of columns: the way patients are played, and their kept rows.

    Fields of subclasses and the sources of their module enter the digest of kept parts.
    """

    columns: ClassVar[tuple[str, ...]] = ("seed",)  # those that kept rows must have
    made_by: ClassVar[tuple[ModuleType, ...]] = ()  # other modules that decide the rows

    @abstractmethod
    def play(self, entry: Any, number: int, seed: int, progress: Callable[[int, int], None]) -> pd.DataFrame:
        """Play ``number`` patients from a seed on, and make their rows, each with its ``seed``.

        Args:
            entry: an `Entry` with a freshly loaded agent; None of a cell without one.
            number: of patients.
            seed: of the first one.
            progress: see `jawenv.play`.
        """


@dataclass(frozen=True)
class Cell:
    """One entry in one world, or something else that is drawn many times."""

    levels: Mapping[str, str | float]  # columns that distinguish its rows from other cells', numbers among them in Hz
    load: Callable[[], Entry] | None  # makes the entry; a function that processes can be sent
    seeds: range  # of the patients
    rows: Rows  # columns of a patient's row
    size: int  # patients that are played together: few enough to lose little when interrupted, enough to be quick

    @property
    def name(self) -> str:
        """Its levels as a text, unique in its study."""
        return " · ".join(f"{level:g} Hz" if isinstance(level, float) else level for level in self.levels.values())

    def parts(self, folder: Path) -> list[Part]:
        """The parts in which it is played, each kept as a table in the folder."""
        decided_by: dict[str, object] = {"rows": asdict(self.rows)}
        made_by = (sys.modules[type(self.rows).__module__], *self.rows.made_by)
        if self.load is None:
            label, named = self.name, digest(decided_by, made_by=made_by)
        else:
            entry = self.load()
            decided_by["cohort"] = entry.world.build_cohort().to_dict()
            label, named = entry.label, fingerprint(entry, decided_by, *made_by)
        parts = []
        for first in self.seeds[:: self.size]:
            number = min(self.size, self.seeds.stop - first)
            path = folder / f"{label.replace('/', '_')}-{first:05d}-{number}-{named}.parquet"
            parts.append(Part(self.name, first, number, path))
        return parts


def play_cells(cells: Sequence[Cell], output: Path, run: Run | None = None, unit: str = "episodes") -> pd.DataFrame:
    """Play all cells, but for parts kept in the output folder.

    Args:
        cells: of a study, with different levels.
        output: folder; its ``parts`` holds the finished parts.
        run: how it is played.
        unit: name of a cell's patients, in the plural.

    Returns:
        The rows of all cells, in their order, each with the levels of its cell as its first columns.
    """
    tables = play_each(cells, output, run, unit)
    return pd.concat([_placed(table, cell) for cell, table in zip(cells, tables, strict=True)], ignore_index=True)


def play_each(
    cells: Sequence[Cell], output: Path, run: Run | None = None, unit: str = "episodes"
) -> list[pd.DataFrame]:
    """The rows of each cell, without its levels; see `play_cells`."""
    folder, by_name = folder_for(output, FOLDER), {cell.name: cell for cell in cells}
    parts = [part for cell in cells for part in cell.parts(folder)]
    tables = finish(
        parts,
        partial(_play_part, cells=by_name),
        lambda part: read_table(part.path, by_name[part.key].rows.columns)[0],
        unit,
        run,
    )
    of_cells: dict[str, list[pd.DataFrame]] = {name: [] for name in by_name}
    for part, table in zip(parts, tables, strict=True):
        of_cells[part.key].append(table)
    return [pd.concat(of_cells[cell.name], ignore_index=True) for cell in cells]


def _play_part(part: Part, progress: Progress, cells: Mapping[str, Cell]) -> None:
    """Play the patients of a part and keep their rows.

    Args:
        part: ``first`` is the seed of the first patient.
        progress: counts patients.
        cells: by their names.
    """
    cell, before = cells[part.key], progress.done
    entry = None if cell.load is None else replace(cell.load(), agent_seed=part.first - cell.seeds.start)
    name = part.key.replace("_", " ")
    rows = cell.rows.play(
        entry,
        part.number,
        part.first,
        lambda step, steps: progress.advance_to(before + part.number * step / steps, name),
    )
    write_table(rows, part.path, {"cell": part.key})


def _placed(rows: pd.DataFrame, cell: Cell) -> pd.DataFrame:
    levels = pd.DataFrame({name: [level] * len(rows) for name, level in cell.levels.items()}, index=rows.index)
    return pd.concat([levels, rows], axis=1)
