"""The tables of a study: as Markdown, with command and versions, and in the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from eval.figures import words
from eval.figures.catalogue import FIGURES
from eval.figures.statistics import Interval
from eval.figures.tables import Table, made_by
from eval.studies.design import Design
from eval.studies.estimates import ALL
from eval.studies.grid import FACTORS

_TITLES = {"control_hz": "steps/s", "reality": "effects"}
NOTE = (
    "Beside each figure its 95 % interval over the patients: bias-corrected and accelerated bootstrap for "
    "means, percentile bootstrap for medians and p90 (worst sd, times), Wilson's for shares. sd are of natural logs: "
    "5 % is 5 % of the parameter. NEES / p is 1 if the filter is calibrated. `never`: that many patients do not "
    "get there."
)
PAIRS_NOTE = (
    "Mean difference, first minus second, on the same patients and noise (of percentages in points); none where a "
    "time is `never`. Better: the probability of improvement, the share of the patients on whom the first is better "
    "than the second, equal ones counted half (Agarwal et al. 2021, NeurIPS 34:29304). Intervals: 95 %, "
    "bias-corrected and accelerated bootstrap of the patients, of each with all settings."
)


def _varying(table: pd.DataFrame) -> list[str]:
    """The factors that tell rows apart, the entry always."""
    return [factor for factor in FACTORS if factor == "entry" or table[factor].nunique() > 1]


def _cell(value: Interval, metric: str) -> str:
    figure = FIGURES[metric]
    return words.with_interval(figure.scaled(value), figure.digits)


def _level(factor: str, level: Any) -> str:
    return f"{level:g}" if isinstance(level, float) else words.label(level) if factor == "entry" else str(level)


def of_cells(table: pd.DataFrame, design: Design) -> Table:
    """The table of cells.

    Args:
        table: of `eval.studies.estimates.cells`.
        design: the study.
    """
    factors = _varying(table)
    head = [_TITLES.get(factor, factor) for factor in factors]
    head += ["patients", *(FIGURES[metric].title for metric in design.metrics)]
    rows = []
    for levels, cell in table.groupby(list(FACTORS), sort=False):
        setting = dict(zip(FACTORS, levels, strict=True))
        records = cell.to_dict("records")
        figures = [_cell(Interval(row["value"], row["low"], row["high"]), row["metric"]) for row in records]
        rows.append([*(_level(factor, setting[factor]) for factor in factors), str(cell["patients"].iloc[0]), *figures])
    return Table(head, rows, _texts(head, rows), NOTE, design.title)


def _of_pairs(table: pd.DataFrame, design: Design) -> Table:
    """The table of pairs, of one with several settings over all of them.

    Args:
        table: of `eval.studies.estimates.pairs`, not empty.
        design: the study.
    """
    factors = [factor for factor in FACTORS if len(set(table[factor]) - {ALL, ""}) > 1]
    head = ["first", "second", *(_TITLES.get(factor, factor) for factor in factors), "patients"]
    head += [FIGURES[metric].title for metric in design.metrics if FIGURES[metric].compared]
    rows = []
    whole = (table[list(FACTORS)] == ALL).any(axis=1)
    several = whole.groupby([table["better"], table["than"]]).transform("any").astype(bool)
    for group, figures in table[whole | ~several].groupby(["better", "than", *FACTORS], sort=False):
        levels = dict(zip(FACTORS, group[2:], strict=True))
        rows.append(
            [
                *(words.label(str(side)) for side in group[:2]),
                *(_level(factor, levels[factor]) or words.NOTHING for factor in factors),
                str(figures["patients"].iloc[0]),
                *(_compared(row) for row in figures.to_dict("records")),
            ]
        )
    return Table(head, rows, _texts(head, rows), PAIRS_NOTE)


def _compared(row: Mapping[Any, Any]) -> str:
    """Difference, and probability of improvement where a direction is better."""
    difference = Interval.of(row, "difference")
    better = Interval.of(row, "probability")
    share = f"better: {words.with_interval(words.scaled(better, 100.0), 0, ' %')}"
    return _cell(difference, row["metric"]) + ("" if np.isnan(better.value) else f"; {share}")


def _texts(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int]:
    return [i for i in range(len(head)) if not any(char.isdigit() for row in rows for char in row[i][:2])]


def markdown(cells: pd.DataFrame, pairs: pd.DataFrame, design: Design, metadata: dict[str, Any]) -> str:
    """The tables of cells and pairs of a study, below its question and a line on their making.

    Args:
        cells: of `eval.studies.estimates.cells`.
        pairs: of `eval.studies.estimates.pairs`.
        design: the study.
        metadata: of `eval.kept.tables.made_with`.
    """
    last = design.seed + design.patients - 1
    same = [f"{factor} {_level(factor, cells[factor].iloc[0])}" for factor in FACTORS if cells[factor].nunique() == 1]
    what = f"{design.patients} patients (seeds {design.seed}–{last}), episodes of {design.episode_s:g} s"
    made = made_by(metadata, ", ".join([what, *same]))
    lines = [f"# {design.title}", *([design.description] if design.description else []), made]
    lines.append(of_cells(cells, design).markdown())
    if len(pairs):
        lines += ["## Pairs", _of_pairs(pairs, design).markdown()]
    return "\n\n".join(lines) + "\n"
