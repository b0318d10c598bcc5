"""Patients' rows of a submission beside the same patients played again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.stats import binomtest
from scipy.stats import t as t_law

from eval.rows.times import COLUMNS, LEVELS

Mask = npt.NDArray[np.bool_]
KEYS = ["task", "agent", "seed"]
TIMES = ("score_s", "claimed_s", *(f"within_{level:g}_s" for level in LEVELS))
LARGEST_SHARE = 0.10
"""Largest relative difference of columns other than times on another platform; times may differ by a control step.

Compiled for a processor without AVX and FMA, 76 of 80 episodes of three tasks differ by less than 1e-6, one by 7 %.
"""
LEAST_CHANCE = 1e-3
"""Differences that lean one way, in number or on average, are a fault if chance does so less often."""
_FEWEST = 10  # rows of which a mean difference is tested
_ROUNDING = 1e-6  # relative: which way smaller differences lean says nothing
_SMALL = 1e-3  # of columns other than times: from here down differences are compared with this


def faults_of(
    submitted: pd.DataFrame, again: pd.DataFrame, step_s: Mapping[tuple[str, str], float] | None
) -> list[str]:
    """Differences beyond rounding, a line each.

    Args:
        submitted: rows of the submission, in any order.
        again: rows of some of its patients, played again.
        step_s: control step by task and agent, where another platform may differ by one; None where every column
            has to be equal to the bit.
    """
    both = again.merge(submitted, on=KEYS, suffixes=("", "_given"), validate="1:1")
    faults = []
    for cell, rows in both.groupby(["task", "agent"], sort=False):
        task, agent = map(str, cell)
        for column in COLUMNS[1:]:
            wrong = _apart(rows, column, None if step_s is None else step_s[task, agent])
            if wrong.any():
                first = rows[wrong].iloc[0]
                faults.append(
                    f"{task}, {agent}: {column} of {wrong.sum()} patients differs, as seed {first['seed']}: "
                    f"{_written(first[f'{column}_given'])} given, {_written(first[column])} played"
                )
    return faults or list(_leaning(both))


def _apart(rows: pd.DataFrame, column: str, step_s: float | None) -> Mask:
    """The rows with a difference above what is allowed."""
    played, submitted = _pair(rows, column)
    equal: Mask = (played == submitted) | (np.isnan(played) & np.isnan(submitted))
    if step_s is None:
        return np.logical_not(equal)
    allowed = np.full(len(rows), (1.0 + _ROUNDING) * step_s)
    if column not in TIMES:
        allowed = LARGEST_SHARE * np.maximum(np.abs(played), _SMALL)
    with np.errstate(invalid="ignore"):  # of two that are infinite
        return np.logical_not(equal | (np.abs(played - submitted) <= allowed))


def _leaning(both: pd.DataFrame) -> Iterator[str]:
    """Columns with differences that lean one way in number or on average, in one score or in all together."""
    cells = [(f"{task}, {agent}", rows) for (task, agent), rows in both.groupby(["task", "agent"], sort=False)]
    for name, rows in [*cells, ("all scores", both)]:
        for column in COLUMNS[1:]:
            played, submitted = _pair(rows, column)
            with np.errstate(invalid="ignore"):
                difference = submitted - played
                counts = np.abs(difference) > _ROUNDING * np.abs(played)
            lower = int((submitted < played)[counts].sum())
            number = int(counts.sum())
            if number and binomtest(lower, number).pvalue < LEAST_CHANCE:
                yield f"{name}: {column} of {max(lower, number - lower)} of {number} patients differs the same way"
                continue
            share = difference if column in TIMES else difference / np.maximum(np.abs(played), _SMALL)
            counted = np.where(counts & np.isfinite(share), share, 0.0)
            if _chance_of_mean(counted) < LEAST_CHANCE:
                unit = "s" if column in TIMES else "of itself"
                yield f"{name}: {column} differs by {counted.mean():.3g} {unit} on average"


def _chance_of_mean(differences: npt.NDArray[np.float64]) -> float:
    """The p value of a mean against 0 (Student's t); 1 of few rows."""
    number = len(differences)
    if number < _FEWEST or not differences.any():
        return 1.0
    error = differences.std(ddof=1) / np.sqrt(number)
    return float(2.0 * t_law.sf(abs(differences.mean()) / max(error, np.finfo(float).tiny), number - 1))


def _pair(rows: pd.DataFrame, column: str) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    return rows[column].to_numpy(dtype=np.float64), rows[f"{column}_given"].to_numpy(dtype=np.float64)


def _written(value: Any) -> str:
    return str(bool(value)) if isinstance(value, bool | np.bool_) else f"{value:.10g}"
