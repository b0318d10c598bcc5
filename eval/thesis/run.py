"""Draw the items, in parts of some draws on all cores.

Every draw has random numbers of its own, made from (seed, item, number of the draw).
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

import eval.thesis
from eval.kept.digest import digest
from eval.kept.parts import Part, Run, finish, folder_for, parts_of
from eval.kept.tables import rows_in, write_table
from eval.thesis.item import Item, Judgement
from jawenv.base.errors import InputError, shown
from jawenv.base.files import write_text
from jawenv.base.progress import Progress
from jawenv.playing.rollout import LARGEST_SEED

CHUNK = 10
ENOUGH = 20
"""Draws, below which no verdict is given."""


@dataclass(frozen=True)
class Draws:
    """The draws of all items."""

    draws: int = 1000  # of each item, >= 2
    seed: int = 0  # of all draws, 0 to ``jawenv.playing.rollout.LARGEST_SEED``
    quick: bool = False  # short episodes and fewer cases, to try the program out

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.draws < 2:
            raise InputError(f"draws is {self.draws}; allowed: 2 or more")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise InputError(f"seed is {shown(self.seed)}; allowed: a whole number, 0 to {LARGEST_SEED}")

    @property
    def decisive(self) -> bool:
        """Whether the draws are enough, and long enough, for a verdict."""
        return self.draws >= ENOUGH and not self.quick


def draw_all(items: Sequence[Item], settings: Draws, output: Path, run: Run | None = None) -> dict[str, pd.DataFrame]:
    """Every draw of every item.

    Args:
        items: the items to draw.
        settings: how often, and from which random numbers.
        output: folder; its ``draws`` holds the parts that are finished.
        run: how it is done.

    Returns:
        Rows of all draws of each item by its key, with a column ``draw``.
    """
    folder = folder_for(output, "draws")
    parts = {item.key: parts_of_item(item, settings, folder) for item in items}
    every = list(dict.fromkeys(part for of_item in parts.values() for part in of_item))
    drawn_parts = finish(every, partial(_draw_part, settings=settings), rows_in, "draws of all results", run)
    return {
        key: pd.concat([drawn_parts[path] for part in of_item for _, path in part.files], ignore_index=True)
        for key, of_item in parts.items()
    }


def parts_of_item(item: Item, settings: Draws, folder: Path) -> list[Part]:
    """The parts that an item's draws are made in; items with the same draws share them."""
    name = digest([settings.seed, settings.quick], made_by=[eval.thesis])
    return parts_of(item.drawn_as, range(settings.draws), CHUNK, folder, {item.drawn_as: name})


def _draw_part(part: Part, progress: Progress, settings: Draws) -> None:
    """Make the draws of a part and keep them, all or none."""
    from eval.thesis.catalogue import ITEMS

    numbers = range(part.first, part.first + part.number)
    rngs = [np.random.default_rng([settings.seed, zlib.crc32(part.key.encode()), number]) for number in numbers]
    drawn = zip(ITEMS[part.key].draw(rngs, settings.quick), numbers, strict=True)
    rows = pd.concat([table.assign(draw=number) for table, number in drawn], ignore_index=True)
    for _, path in part.files:
        write_table(rows, path, {})


def keep(item: Item, table: pd.DataFrame, finding: Judgement, settings: Draws, output: Path) -> None:
    """Write an item's rows as Parquet and its finding as JSON."""
    write_table(table, output / f"{item.key}.parquet", {})
    content = {
        "title": item.title,
        "where": item.where,
        "says": item.says,
        "how": item.how,
        "settings": asdict(settings),
        **asdict(finding),
    }
    write_text(output / f"{item.key}.json", json.dumps(content, indent=2, ensure_ascii=False))
