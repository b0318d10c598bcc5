"""Draw the items: in chunks, on all cores, each chunk kept on disk as soon as it is finished.

Every draw has random numbers of its own, made from (seed, item, number of the draw), so that results depend neither on
the number of cores nor on how often a run was interrupted.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console

import agents
import jawenv
from eval.chunks import Chunk, finish, folder_for
from eval.tables import read_table, write_table
from eval.thesis.item import Finding, Item
from jawenv.errors import InputError, shown
from jawenv.files import atomic_write
from jawenv.playing.rollout import LARGEST_SEED
from jawenv.versions import package_versions

CHUNK = 10
ENOUGH = 20
"""Draws, below which no verdict is given."""
_SOURCES = {".py", ".toml", ".yaml", ".json", ".csv"}


@dataclass(frozen=True)
class Settings:
    """How the items are drawn.

    Attributes:
        draws: of each item, >= 2.
        seed: of all draws, 0 to ``jawenv.playing.rollout.LARGEST_SEED``.
        quick: short episodes and fewer cases, to try the program out.

    Raises:
        InputError: a number out of range.
    """

    draws: int = 1000
    seed: int = 0
    quick: bool = False

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.draws < 2:
            raise InputError(f"draws: {self.draws} given, allowed is 2 or more")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise InputError(f"seed: {shown(self.seed)} given, allowed is a whole number, 0 to {LARGEST_SEED}")

    @property
    def decisive(self) -> bool:
        """Whether the draws are enough, and long enough, for a verdict."""
        return self.draws >= ENOUGH and not self.quick


def chunks_of(item: Item, settings: Settings, folder: Path) -> list[Chunk]:
    """The chunks that an item's draws are made in; items with the same draws share them."""
    key = item.drawn_as
    chunks = []
    for first in range(0, settings.draws, CHUNK):
        number = min(CHUNK, settings.draws - first)
        what = [key, first, number, settings.seed, settings.quick, program_digest()]
        name = hashlib.sha256(json.dumps(what).encode()).hexdigest()[:16]
        chunks.append(Chunk(key, first, number, ((key, folder / f"{key}-{first:05d}-{name}.parquet"),)))
    return chunks


@cache
def program_digest() -> str:
    """Changes with whatever could change a draw: packages, sources and data of jawenv, agents and these items."""
    content = hashlib.sha256(json.dumps(package_versions()).encode())
    for folder in (Path(jawenv.__file__).parent, Path(agents.__file__).parent, Path(__file__).parent):
        for file in sorted(file for file in folder.rglob("*") if file.suffix in _SOURCES):
            content.update(file.name.encode())
            content.update(file.read_bytes())
    return content.hexdigest()[:16]


def draw_all(
    items: Sequence[Item],
    settings: Settings,
    output: Path,
    *,
    fresh: bool = False,
    workers: int | None = None,
    console: Console | None = None,
) -> dict[str, pd.DataFrame]:
    """Every draw of every item.

    Args:
        items: what to draw.
        settings: how often, and from which random numbers.
        output: folder; its ``draws`` holds the chunks.
        fresh: draw again what the folder holds.
        workers: processes; all cores by default. 1 draws in this process.
        console: where progress is shown; nowhere by default.

    Returns:
        Rows of all draws of each item by its key, with a column ``draw``.

    Raises:
        InputError: the output folder cannot be used, or a kept file is damaged.
    """
    folder = folder_for(output, "draws")
    plan = {item.key: chunks_of(item, settings, folder) for item in items}
    chunks = list(dict.fromkeys(chunk for of_item in plan.values() for chunk in of_item))
    finish(chunks, partial(draw_chunk, settings=settings), "draws", fresh=fresh, workers=workers, console=console)
    return {
        key: pd.concat([read_table(path)[0] for chunk in of_item for _, path in chunk.files], ignore_index=True)
        for key, of_item in plan.items()
    }


def draw_chunk(chunk: Chunk, settings: Settings) -> None:
    """Make the draws of a chunk and keep them, all or none."""
    from eval.thesis.catalogue import ITEMS

    numbers = range(chunk.first, chunk.first + chunk.number)
    rngs = [np.random.default_rng([settings.seed, zlib.crc32(chunk.key.encode()), number]) for number in numbers]
    drawn = zip(ITEMS[chunk.key].draw(rngs, settings.quick), numbers, strict=True)
    rows = pd.concat([table.assign(draw=number) for table, number in drawn], ignore_index=True)
    for _, path in chunk.files:
        write_table(rows, path, {})


def keep(item: Item, table: pd.DataFrame, finding: Finding, settings: Settings, output: Path) -> None:
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
    with atomic_write(output / f"{item.key}.json") as unfinished:
        unfinished.write_text(json.dumps(content, indent=2, ensure_ascii=False), encoding="utf-8")
