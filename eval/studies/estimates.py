"""Estimates for all patients from those of a study: figures of cells, and paired comparisons.

Intervals are over patients, 95 %. Probabilities of improvement are those that Agarwal et al. (2021,
NeurIPS 34:29304, `rliable`) recommend, with patients for runs and settings for tasks. Two things differ. Both sides of
a pair meet the same patients and noise, so that they are compared patient by patient. And a seed makes the patient of
every setting, so that settings are not independent: seeds are resampled, each with its rows of all settings, where
`rliable` resamples the runs of each task by themselves. Every resample has all settings equally often, as there.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from eval.figures import statistics
from eval.figures.catalogue import FIGURES
from eval.figures.statistics import UNKNOWN
from eval.studies.design import Design, Pair
from eval.studies.grid import FACTORS, Levels, matches

Array = npt.NDArray[np.float64]
ALL = "all settings"


def cells(rows: pd.DataFrame, design: Design) -> pd.DataFrame:
    """The metrics of every cell.

    Args:
        rows: of `eval.kept.cells.play_cells`.
        design: the study.

    Returns:
        One row per cell and metric: `FACTORS`, patients, metric, value, low, high. NaN where a metric is not defined,
        as the bound while an effect is on that the filter does not know.
    """
    table = []
    for levels, cell in rows.groupby(list(FACTORS), sort=False):
        factors = dict(zip(FACTORS, levels, strict=True))
        for metric in design.metrics:
            interval = FIGURES[metric].interval(cell)
            table.append(factors | {"patients": len(cell), "metric": metric} | vars(interval))
    return pd.DataFrame(table)


def pairs(rows: pd.DataFrame, design: Design) -> pd.DataFrame:
    """The two sides of every pair, patient by patient, under every setting that both are played in, and over all.

    Args:
        rows: of `eval.kept.cells.play_cells`.
        design: the study.

    Returns:
        One row per pair, setting and metric: `better` and `than` (the sides), the other factors, patients, metric;
        `difference`, mean of the first side's value minus the second's; `probability` that the first is better than
        the second on a patient, equal ones counted half; each with `_low` and `_high`. NaN where they are not defined.
        Factors of the row over all settings are `all settings`; those in which the sides differ are empty.
    """
    by_cell = {tuple(levels): cell.set_index("seed") for levels, cell in rows.groupby(list(FACTORS), sort=False)}
    return pd.DataFrame([row for pair in design.pairs for row in _rows_of_pair(pair, by_cell, design)])


def _rows_of_pair(pair: Pair, by_cell: dict[Levels, pd.DataFrame], design: Design) -> Iterator[dict[str, Any]]:
    met = []
    for levels, partner in matches(pair, list(by_cell), design):
        one, other = _same_patients(by_cell[levels], by_cell[partner])
        # Factors in which the sides differ are empty.
        texts = [_text(level) if level == their else "" for level, their in zip(levels, partner, strict=True)]
        if len(one):
            met.append((dict(zip(FACTORS, texts, strict=True)), one, other))
    sides = {"better": str(pair[0]), "than": str(pair[1])}
    for metric in design.metrics:
        if not FIGURES[metric].compared:
            continue
        tables = [_by_patient(one, other, metric) for _, one, other in met]
        for (factors, *_), table in zip(met, tables, strict=True):
            yield sides | factors | {"patients": len(table), "metric": metric} | _compared(table)
        if len(met) > 1:
            factors = {factor: level and ALL for factor, level in met[0][0].items()}
            table = _means(tables)
            yield sides | factors | {"patients": len(table), "metric": metric} | _compared(table)


def _means(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """Means over the settings, of the seeds played under all of them."""
    by_seed = pd.concat(tables).groupby(level="seed")
    return by_seed.mean()[by_seed.size() == len(tables)]


def _text(level: object) -> str:
    return f"{level:g}" if isinstance(level, float) else str(level)


def _same_patients(one: pd.DataFrame, other: pd.DataFrame) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The rows of those patients that both cells have, in the same order.

    One whom the device cannot treat is drawn again, which effects may decide, so that the parameters are compared too.
    """
    seeds = one.index.intersection(other.index)
    one, other = one.loc[seeds], other.loc[seeds]
    truths = [table.filter(like="truth/").fillna(0.0).to_numpy() for table in (one, other)]
    same = (truths[0] == truths[1]).all(axis=1)
    return one[same], other[same]


def _by_patient(one: pd.DataFrame, other: pd.DataFrame, metric: str) -> pd.DataFrame:
    """Difference and whether the first is better, by the patients' seeds; NaN where they are not defined."""
    figure = FIGURES[metric]
    values, reference = figure.of(one), figure.of(other)
    finite = np.isfinite(values).all() and np.isfinite(reference).all()
    higher = figure.better == "higher"
    ordered = figure.better in ("higher", "lower") and not (np.isnan(values).any() or np.isnan(reference).any())
    nothing = np.full(len(one), np.nan)
    return pd.DataFrame(
        {
            "difference": values - reference if finite else nothing,
            "probability": statistics.better(values, reference, higher=higher) if ordered else nothing,
        },
        index=one.index,
    )


def _compared(table: pd.DataFrame) -> dict[str, float]:
    figures: dict[str, float] = {}
    for name in ("difference", "probability"):
        values = table[name].to_numpy(dtype=np.float64)
        interval = UNKNOWN if np.isnan(values).any() or not len(values) else statistics.mean(values)
        figures |= interval.columns(name)
    return figures
