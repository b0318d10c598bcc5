"""Calibration of nuisances: means of each group over the patients."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pandas as pd

from eval.figures import statistics, words
from eval.figures.statistics import Interval
from eval.rows.nuisances import ERROR, GROUPS, LEFT

NOTE = (
    "What is known only within an sd beside the muscles: the mean of (error / sd) squared of a group, 1 if honest, and "
    "the mean sd that is left, in % of the sd before anything was measured. What a maneuver leaves below 100 % it "
    "calibrates."
)


def summarised(judged: pd.DataFrame) -> dict[str, float]:
    """Means over patients of the columns of each group; of the squares also the ends of 95 % intervals."""
    figures: dict[str, float] = {}
    for group in groups_in(judged):
        squares, left = judged[f"{ERROR}/{group}"], judged[f"{LEFT}/{group}"]
        figures |= statistics.mean(squares.to_numpy()).columns(f"{ERROR}/{group}") | {f"{LEFT}/{group}": left.mean()}
    return figures


def groups_in(table: pd.DataFrame) -> list[str]:
    """The groups that rows or a summary have, in the order of ``GROUPS``."""
    return [group for group in GROUPS if f"{ERROR}/{group}" in table.columns and table[f"{LEFT}/{group}"].notna().any()]


def columns_of(summary: pd.DataFrame) -> dict[str, Callable[[pd.Series], str]]:
    """Texts of a row of `eval.calibration.summary.summarise` by their headings, which are the groups."""
    return {group: partial(_cell, group=group) for group in groups_in(summary)}


def _cell(row: pd.Series, group: str) -> str:
    """A cell such as `1.02 (0.93 … 1.12), 64 %`."""
    left = words.percent(row[f"{LEFT}/{group}"], 0)
    return f"{words.with_interval(Interval.of(row, f'{ERROR}/{group}'), 2)}, {left} %"
