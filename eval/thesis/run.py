"""Draw the items: in chunks, on all cores, each chunk kept on disk as soon as it is finished.

Every draw has random numbers of its own, made from (seed, item, number of the draw), so that results depend neither on
the number of cores nor on how often a run was interrupted.
"""

from __future__ import annotations

import hashlib
import json
import os
import zlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import agents
import jawenv
from eval.pool import run_all, stopped
from eval.thesis.item import Item
from jawenv.errors import InputError

CHUNK = 10
_SOURCES = {".py", ".toml", ".yaml", ".json", ".csv"}


@dataclass(frozen=True)
class Settings:
    """How the items are drawn.

    Attributes:
        draws: of each item, >= 2.
        seed: of all draws, >= 0.
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
        if self.seed < 0:
            raise InputError(f"seed: {self.seed} given, allowed is 0 or more")


@dataclass(frozen=True)
class Chunk:
    """Some draws of an item, and the file that keeps them."""

    key: str
    first: int
    number: int
    path: Path


def chunks_of(item: Item, settings: Settings, folder: Path) -> list[Chunk]:
    """The chunks that an item's draws are made in; items with the same draws share them."""
    key = item.drawn_as
    found = []
    for first in range(0, settings.draws, CHUNK):
        number = min(CHUNK, settings.draws - first)
        what = [key, first, number, settings.seed, settings.quick, program_digest()]
        name = hashlib.sha256(json.dumps(what).encode()).hexdigest()[:16]
        found.append(Chunk(key, first, number, folder / f"{key}-{first:05d}-{name}.parquet"))
    return found


@cache
def program_digest() -> str:
    """Changes with whatever could change a draw: the sources and data of jawenv, the agents and these items."""
    content = hashlib.sha256()
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
    progress: Callable[[str, int, bool], None] | None = None,
) -> dict[str, pd.DataFrame]:
    """Every draw of every item.

    Args:
        items: what to draw.
        settings: how often, and from which random numbers.
        output: folder; its ``draws`` holds the chunks.
        fresh: draw again what the folder holds.
        workers: processes; all cores by default. 1 draws in this process.
        progress: called with (item's key, draws finished, whether they were kept from before).

    Returns:
        Rows of all draws of each item by its key, with a column ``draw``.

    Raises:
        InputError: the output folder cannot be used, or a kept file is damaged.
    """
    folder = output / "draws"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"output {output}: {error.strerror}") from None
    plan = {item.key: chunks_of(item, settings, folder) for item in items}
    wanted = list(dict.fromkeys(chunk for chunks in plan.values() for chunk in chunks))
    missing = [chunk for chunk in wanted if fresh or not chunk.path.exists()]
    told = progress or (lambda key, number, known: None)
    for chunk in wanted:
        if chunk not in missing:
            told(chunk.key, chunk.number, True)
    work = partial(draw_chunk, settings=settings)
    run_all(work, missing, lambda chunk: told(chunk.key, chunk.number, False), workers)
    return {key: pd.concat([_read(chunk.path) for chunk in chunks], ignore_index=True) for key, chunks in plan.items()}


def draw_chunk(chunk: Chunk, settings: Settings) -> None:
    """Make the draws of a chunk and keep them, all or none."""
    from eval.thesis.catalogue import ITEMS

    numbers, parts = range(chunk.first, chunk.first + chunk.number), []
    rngs = [np.random.default_rng([settings.seed, zlib.crc32(chunk.key.encode()), number]) for number in numbers]
    drawn = ITEMS[chunk.key].draw(rngs, settings.quick)
    for number in numbers:
        if stopped():
            return
        parts.append(next(drawn).assign(draw=number))
    unfinished = chunk.path.with_name(f"{chunk.path.name}.{os.getpid()}.unfinished")
    pd.concat(parts, ignore_index=True).to_parquet(unfinished, index=False, compression="zstd")
    os.replace(unfinished, chunk.path)


def _read(path: Path) -> pd.DataFrame:
    try:
        return pd.read_parquet(path)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path} is damaged ({reason}); delete it, or use --fresh") from None


def keep(item: Item, table: pd.DataFrame, finding: Any, settings: Settings, output: Path) -> None:
    """Write an item's rows as Parquet and its finding as JSON."""
    table.to_parquet(output / f"{item.key}.parquet", index=False, compression="zstd")
    told = {
        "title": item.title,
        "where": item.where,
        "says": item.says,
        "how": item.how,
        "settings": asdict(settings),
        **asdict(finding),
    }
    (output / f"{item.key}.json").write_text(json.dumps(told, indent=2, ensure_ascii=False), encoding="utf-8")
