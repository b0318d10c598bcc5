"""The results of Young (2016) as a study: every draw of every result, judged, in a table and on a page.

Every draw has random numbers of its own, made from (seed, result, number of the draw).
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from rich.console import Console

import eval.thesis
from eval.figures import words
from eval.figures.tables import Table, made_by
from eval.kept.cells import Cell, Rows, play_each
from eval.kept.parts import Run
from eval.kept.tables import write_table
from eval.thesis.catalogue import ITEMS
from eval.thesis.item import Item, Judgement
from jawenv.base.files import write_text
from jawenv.base.locks import alone

TOGETHER = 10
ENOUGH = 20
"""Draws, below which no verdict is given."""
UNDECIDED = "too few draws"


@dataclass(frozen=True)
class Draws(Rows):
    """The rows of an item's draws, which have a column ``draw``."""

    columns = ("draw",)
    made_by: ClassVar[tuple[ModuleType, ...]] = (eval.thesis,)
    item: str  # key of the item that owns the draws
    seed: int  # of all draws

    def play(self, entry: Any, number: int, seed: int, progress: Callable[[int, int], None]) -> pd.DataFrame:
        """See `Rows`; ``seed`` is the number of the first draw."""
        numbers = range(seed, seed + number)
        rngs = [np.random.default_rng([self.seed, zlib.crc32(self.item.encode()), draw]) for draw in numbers]
        drawn = zip(ITEMS[self.item].draw(rngs), numbers, strict=True)
        return pd.concat([table.assign(draw=draw) for table, draw in drawn], ignore_index=True)


def draw_all(
    items: Sequence[Item], draws: int, seed: int, output: Path, run: Run | None = None
) -> dict[str, pd.DataFrame]:
    """Every draw of every item.

    Args:
        items: the items to draw.
        draws: how many of each, 2 or more.
        seed: of all draws.
        output: folder, which keeps finished parts.
        run: how it is done.

    Returns:
        Rows of all draws of each item by its key.
    """
    keys = list(dict.fromkeys(item.drawn_as for item in items))
    cells = [Cell({"result": key}, None, range(draws), Draws(key, seed), TOGETHER) for key in keys]
    tables = dict(zip(keys, play_each(cells, output, run, "draws of all results"), strict=True))
    return {item.key: tables[item.drawn_as] for item in items}


def study(
    items: Sequence[Item], draws: int, seed: int, output: Path, run: Run, metadata: dict[str, Any], console: Console
) -> dict[str, Judgement]:
    """Draw, judge, print and write ``study.md`` and a Parquet file for each item; see `draw_all`.

    Returns:
        The findings by the items' keys.
    """
    tables = draw_all(items, draws, seed, output, run)
    findings = {item.key: item.judge(tables[item.key]) for item in items}
    with alone(output):
        for key, table in tables.items():
            write_table(table, output / f"{key}.parquet", metadata)
        write_text(output / "study.md", _markdown(items, findings, draws, metadata))
    for item in items:
        console.print(f"{item.title}, {item.where}: {_verdict(findings[item.key], draws)}", soft_wrap=True)
        _table(findings[item.key]).show(console)
    console.print(f"tables:  {output / 'study.md'}\nresults: {output}/*.parquet", soft_wrap=True)
    return findings


def _table(finding: Judgement) -> Table:
    figures = [[name, words.with_interval(value, 2)] for name, value in finding.figures.items()]
    return Table(["figure", "measured"], figures)


def _markdown(items: Sequence[Item], findings: Mapping[str, Judgement], draws: int, metadata: dict[str, Any]) -> str:
    """The page: of every result what the thesis says, our setting, what we measure, and the verdict."""
    lines = ["# The results of Young (2016), drawn again", made_by(metadata, f"{draws} draws of each")]
    for item in items:
        lines += [f"## {item.title}", f"{item.where}. {item.says}", f"Here: {item.how}"]
        lines += [_table(findings[item.key]).markdown(), f"**{_verdict(findings[item.key], draws)}**"]
    return "\n\n".join(lines) + "\n"


def _verdict(finding: Judgement, draws: int) -> str:
    return finding.verdict if draws >= ENOUGH else UNDECIDED
