"""Figures over patients with their bootstrap intervals: conclusions from the patients of a study on all patients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import bootstrap

Array = npt.NDArray[np.float64]
RESAMPLES = 2000
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Interval:
    """A figure over patients with the ends of its 95 % confidence interval (NaN where there is none)."""

    value: float
    low: float
    high: float

    @property
    def exists(self) -> bool:
        """Whether there is an interval: it takes two patients."""
        return not (np.isnan(self.low) or np.isnan(self.high))

    @classmethod
    def of(cls, row: Any, name: str) -> Interval:
        """The interval in a row's columns of `columns`."""
        return cls(row[name], row[f"{name}_low"], row[f"{name}_high"])

    def columns(self, name: str) -> dict[str, float]:
        """Columns of a table: ``name``, and the ends with ``_low`` and ``_high`` behind it."""
        return {name: self.value, f"{name}_low": self.low, f"{name}_high": self.high}


UNKNOWN = Interval(float("nan"), float("nan"), float("nan"))


def over_patients(statistic: Callable[[Array], Array], values: Array, method: str) -> Interval:
    """Bootstrap a statistic of the rows of `values`; `statistic` reduces axis -2 of (..., N, columns)."""
    estimate = float(statistic(values[None])[0])
    if len(values) < 2 or not np.isfinite(estimate):
        return Interval(estimate, float("nan"), float("nan"))
    if np.all(values == values[0]):
        return Interval(estimate, estimate, estimate)

    def of_rows(rows: Array, axis: int = -1) -> Array:
        return statistic(values[rows.astype(np.intp)])

    ends = bootstrap(
        (np.arange(len(values)),),
        of_rows,
        n_resamples=RESAMPLES,
        batch=max(1, 4_000_000 // values.size),
        confidence_level=CONFIDENCE,
        method=method,
        rng=np.random.default_rng(0),
    ).confidence_interval
    return Interval(estimate, float(ends.low), float(ends.high))


def mean(values: Array) -> Interval:
    """Mean over patients.

    Args:
        values: (N,) one per patient.
    """
    column = np.asarray(values, dtype=np.float64)[:, None]
    return over_patients(lambda x: x[..., 0].mean(axis=-1), column, "BCa")
