"""The catalogue of figures: how each is computed of a patient, summed up over patients, headed and written.

Studies, the ranking, its tables in the terminal and on the report's page, gains and cards take their figures
from here by name. sd are of natural logs, so 5 % is 5 % of the parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
import numpy.typing as npt
import pandas as pd

from eval.figures import statistics, words
from eval.figures.statistics import UNKNOWN, Interval
from jawenv.metrics import TARGETS, alarm_rings

Array = npt.NDArray[np.float64]
Better = Literal["higher", "lower"]

PER_S = 30.0
"""Discomfort is judged per so many seconds, the usual length of an episode."""
ADMITTED_S = 0.1
"""Admitted discomfort in ``PER_S``, unless said otherwise."""
DIFFERENCE = "difference"
"""Name of the figure that `gained` makes."""
SIGMAS = {1: 0.6827, 2: 0.9545, 3: 0.9973}
"""Share of a Gaussian within so many standard deviations of its mean."""
SUMMARIES: Mapping[str, Callable[[Array], Interval]] = MappingProxyType(
    {
        "mean": statistics.mean,
        "median": lambda values: statistics.quantile(values, 0.5),
        "p90": lambda values: statistics.quantile(values, 0.9),
        "largest": lambda values: Interval(float(values.max()), np.nan, np.nan),
        # Of two columns of all patients together: discomfort and duration.
        "rate": lambda values: Interval(float(PER_S * np.divide(*values.sum(axis=0))), np.nan, np.nan),
        # Of a column of errors for each parameter, then of their bounds.
        "ratio": lambda values: statistics.rmse_over_bound(*np.hsplit(values, 2)),
    }
)
"""How the values of the patients become one figure, with its interval where there is one."""


@dataclass(frozen=True)
class Figure:
    """One figure."""

    name: str
    title: str  # its heading, with its unit
    better: Better | float | None = None  # the better direction, or the best value; None where neither is
    statistic: str = "mean"  # one of ``SUMMARIES``; where some may be infinite, their median or 90 % quantile
    scale: float = 1.0  # factor in tables
    digits: int = 1  # behind the point in tables
    narrow: str = ""  # its heading in narrow tables; ``{parameters}`` stands for their number
    column: str = ""  # of the patients' table; the one of its name by default
    computed: Callable[[pd.DataFrame], Array] | None = None  # in place of a column
    bound: bool = False  # whether it takes the posterior Cramér-Rao bound

    def of(self, rows: pd.DataFrame) -> Array:
        """Its values (N,) of N patients; of some statistics several columns."""
        return self.computed(rows) if self.computed else rows[self.column or self.name].to_numpy(dtype=np.float64)

    @property
    def compared(self) -> bool:
        """Whether it is compared patient by patient; a quantile's comparison would repeat the median's."""
        return self.statistic in ("mean", "median")

    def interval(self, rows: pd.DataFrame) -> Interval:
        """The figure over the patients of some rows; unknown where it is not defined of one of them."""
        values = self.of(rows)
        return UNKNOWN if np.isnan(values).any() else SUMMARIES[self.statistic](values)

    def scaled(self, estimate: Interval) -> Interval:
        """The estimate in the unit of tables."""
        return words.scaled(estimate, self.scale)

    def value(self, estimate: Interval, digits: int | None = None) -> str:
        """The estimate as a text without its interval, with some digits behind the point or the figure's own."""
        return words.number(self.scale * estimate.value, self.digits if digits is None else digits)


def _per_parameter(column: str) -> Callable[[pd.DataFrame], Array]:
    """A column over the number of parameters in the rows' model, whose columns hold numbers."""
    return lambda rows: rows[column].to_numpy(dtype=np.float64) / rows.filter(like="truth/").iloc[0].notna().sum()


def _of_parameters(rows: pd.DataFrame, *kinds: str) -> Array:
    """Columns of some kinds side by side, each of all parameters."""
    names = [name for kind in kinds for name in map(str, rows) if name.startswith(f"{kind}/")]
    return rows[names].to_numpy(dtype=np.float64)


def per_30_s(rows: pd.DataFrame) -> Array:
    """(N,) discomfort of each patient, s in 30 s."""
    return PER_S * (rows["discomfort_s"] / rows["duration_s"]).to_numpy(dtype=np.float64)


def above_limit(limit_s: float) -> Figure:
    """The share of patients with more discomfort than a limit, s in 30 s."""
    title = f"above {limit_s:g} s of discomfort in {PER_S:g} s, % of patients"
    return Figure(
        "above_limit", title, "lower", scale=100.0, computed=lambda rows: (per_30_s(rows) > limit_s).astype(np.float64)
    )


def gained(reference: pd.DataFrame) -> Figure:
    """True information less that of a reference on the same patients, whose rows they are."""
    less = reference["information_true"].to_numpy(dtype=np.float64)
    return Figure(
        DIFFERENCE,
        "true information less the reference's, nats",
        "higher",
        narrow="minus that of\nthe reference",
        computed=lambda rows: rows["information_true"].to_numpy(dtype=np.float64) - less,
    )


def time_to(target: float) -> str:
    """Name of the time until the worst sd is at a target."""
    return f"time_to_{100.0 * target:g}"


def reaches(target: float) -> str:
    """Name of the share of patients whose worst sd comes to a target."""
    return f"reaches_{100.0 * target:g}"


def _of_target(target: float) -> Iterator[Figure]:
    name, column, percent = time_to(target), f"time_to_{target:g}_s", f"{100.0 * target:g} %"
    yield Figure(name, f"time to {percent}, s", "lower", "median", column=column)
    yield Figure(f"{name}_p90", f"time to {percent}, p90, s", "lower", "p90", column=column)
    yield Figure(
        reaches(target),
        f"reach {percent}, % of patients",
        "higher",
        scale=100.0,
        computed=lambda rows: np.isfinite(rows[column].to_numpy(dtype=np.float64)).astype(np.float64),
    )


_ALL = (
    Figure("information_true", "true information, nats", "higher"),
    Figure("information_claimed", "claimed information, nats", "higher"),
    Figure("information_bound", "bound on information, nats", "higher", bound=True),
    Figure("honesty_gap", "claimed − true, nats", 0.0),
    Figure("nees", "NEES", narrow="NEES\ncalibrated: {parameters}"),
    Figure("nees_per_parameter", "NEES / p", 1.0, digits=2, computed=_per_parameter("nees")),
    Figure("nees_prior", "NEES of the prior"),
    Figure("known_nees", "NEES when within 5 %", statistic="median"),
    Figure("known_nees_p90", "NEES when within 5 %, p90", statistic="p90", column="known_nees"),
    *(Figure(f"inside_{n}_sigma", f"inside {n} sd, %", share, scale=100.0) for n, share in SIGMAS.items()),
    Figure("worst_sd", "worst sd, %", "lower", "median", 100.0, 2),
    Figure(
        "median_sd",
        "median sd of the parameters, %",
        "lower",
        "median",
        100.0,
        2,
        computed=lambda rows: np.nanmedian(_of_parameters(rows, "sd"), axis=1),
    ),
    Figure("early_worst_sd", "worst sd after 10 s, %", "lower", "median", 100.0, 2),
    Figure("worst_sd_p90", "worst sd, p90, %", "lower", "p90", 100.0, 2, column="worst_sd"),
    Figure("worst_sd_max", "worst sd, largest, %", "lower", "largest", 100.0, 2, column="worst_sd"),
    Figure("early_worst_sd_p90", "worst sd after 10 s, p90, %", "lower", "p90", 100.0, 2, column="early_worst_sd"),
    Figure("early_information_true", "true information after 10 s, nats", "higher"),
    Figure("early_nees_per_parameter", "NEES / p after 10 s", 1.0, digits=2, computed=_per_parameter("early_nees")),
    Figure("early_rmse", "RMSE after 10 s, %", "lower", scale=100.0),
    Figure("worst_bound_sd", "worst sd of the bound, %", "lower", "median", 100.0, 2, bound=True),
    Figure("rmse", "RMSE, %", "lower", scale=100.0),
    Figure(
        "rmse_over_bound",
        "RMSE / bound",
        1.0,
        "ratio",
        digits=2,
        narrow="RMSE /\nbound",
        computed=lambda rows: _of_parameters(rows, "error", "bound_sd"),
        bound=True,
    ),
    Figure("identified", "parameters known", "higher", narrow="known\nof {parameters}"),
    *(figure for target in TARGETS for figure in _of_target(target)),
    Figure("verdicts_s", "all verdicts of the data after, s", "lower", "median", narrow="verdicts\ns"),
    Figure("discomfort_s", "discomfort, s", "lower", digits=3),
    Figure(
        "discomfort_rate",
        f"discomfort, s per {PER_S:g} s",
        "lower",
        "rate",
        digits=2,
        narrow=f"discomfort\ns per {PER_S:g} s",
        computed=lambda rows: rows[["discomfort_s", "duration_s"]].to_numpy(dtype=np.float64),
    ),
    above_limit(ADMITTED_S),
    Figure("violated", "violating episodes, %", "lower", scale=100.0, narrow="violating\nepisodes, %"),
    Figure(
        "rings",
        "alarm rings, % of episodes",
        "lower",
        scale=100.0,
        narrow="alarm\nrings, %",
        computed=lambda rows: alarm_rings(rows["misfit"].to_numpy(dtype=np.float64)).astype(np.float64),
    ),
    Figure("governor", "governor, % of the time", "lower", scale=100.0, narrow="governor\n%"),
)
FIGURES: Mapping[str, Figure] = MappingProxyType({figure.name: figure for figure in _ALL})
"""Every figure by its name."""
