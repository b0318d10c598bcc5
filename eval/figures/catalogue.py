"""The catalogue of figures: how each is computed of a patient, summed up over patients, headed and written.

Studies, the ranking, its tables in the terminal and on the report's page, gains, contests and cards take their figures
from here by name. sd are of natural logs, so 5 % is 5 % of the parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
Of = Callable[[pd.DataFrame], Array]
Better = Literal["higher", "lower"]
Statistic = Literal["mean", "median", "p90", "largest", "rate", "ratio"]

PER_S = 30.0
"""Discomfort is judged per so many seconds, the usual length of an episode."""
ADMITTED_S = 0.1
"""Of discomfort in ``PER_S``, unless said otherwise."""
SIGMAS = {1: 0.6827, 2: 0.9545, 3: 0.9973}
"""Share of a Gaussian within so many standard deviations of its mean."""


def _largest(values: Array) -> Interval:
    return Interval(float(values.max()), np.nan, np.nan)


def _rate(values: Array) -> Interval:
    """Of columns of discomfort and duration, s: of all episodes together, in ``PER_S``."""
    discomfort_s, duration_s = values.sum(axis=0)
    return Interval(float(PER_S * discomfort_s / duration_s), np.nan, np.nan)


def _ratio(values: Array) -> Interval:
    """Of columns of errors and as many of their bounds."""
    error, bound_sd = np.hsplit(values, 2)
    return statistics.rmse_over_bound(error, bound_sd)


SUMMARIES: Mapping[Statistic, Callable[[Array], Interval]] = MappingProxyType(
    {
        "mean": statistics.mean,
        "median": lambda values: statistics.quantile(values, 0.5),
        "p90": lambda values: statistics.quantile(values, 0.9),
        "largest": _largest,
        "rate": _rate,
        "ratio": _ratio,
    }
)
"""How the values of the patients become one figure, with its interval where there is one."""


@dataclass(frozen=True)
class Figure:
    """One figure."""

    title: str  # its heading, with its unit
    of: Of  # its values (N,) from the rows of N patients; the last two statistics take (N, columns)
    better: Better | float | None = None  # the better direction, or the best value; None where neither is
    statistic: Statistic = "mean"  # over the patients; where some may be infinite, their median or 90 % quantile
    scale: float = 1.0  # factor in tables
    digits: int = 1  # behind the point in tables
    narrow: str = ""  # its heading in narrow tables; ``{parameters}`` stands for their number
    bound: bool = False  # whether it takes the posterior Cramér-Rao bound

    @property
    def compared(self) -> bool:
        """Whether it is compared patient by patient; a quantile's comparison would repeat the median's."""
        return self.statistic in ("mean", "median")

    def interval(self, rows: pd.DataFrame) -> Interval:
        """The figure over the patients of some rows; unknown where it is not defined of one of them."""
        values = self.of(rows)
        return UNKNOWN if np.isnan(values).any() else SUMMARIES[self.statistic](values)

    def scaled(self, estimate: Interval) -> Interval:
        """In the unit of tables."""
        return words.scaled(estimate, self.scale)

    def value(self, estimate: Interval, digits: int | None = None) -> str:
        """Written without its interval, with so many digits behind the point or the figure's own."""
        return words.number(self.scale * estimate.value, self.digits if digits is None else digits)


def _column(name: str) -> Of:
    return lambda rows: rows[name].to_numpy(dtype=np.float64)


def _reached(name: str) -> Of:
    return lambda rows: np.isfinite(rows[name].to_numpy(dtype=np.float64)).astype(np.float64)


def _per_parameter(name: str) -> Of:
    """Parameters are those that the rows' model has: their columns hold numbers."""
    return lambda rows: rows[name].to_numpy(dtype=np.float64) / rows.filter(like="truth/").iloc[0].notna().sum()


def _columns(*names: str) -> Of:
    return lambda rows: rows[list(names)].to_numpy(dtype=np.float64)


def _of_parameters(*kinds: str) -> Of:
    """Columns of some kinds side by side, each of all parameters."""

    def of(rows: pd.DataFrame) -> Array:
        return rows[[name for kind in kinds for name in map(str, rows) if name.startswith(f"{kind}/")]].to_numpy(float)

    return of


def _median_sd(rows: pd.DataFrame) -> Array:
    median: Array = np.nanmedian(_of_parameters("sd")(rows), axis=1)
    return median


def _rings(rows: pd.DataFrame) -> Array:
    return alarm_rings(rows["misfit"].to_numpy(dtype=np.float64)).astype(np.float64)


def per_30_s(rows: pd.DataFrame) -> Array:
    """(N,) discomfort of each patient, s in 30 s."""
    return PER_S * (rows["discomfort_s"] / rows["duration_s"]).to_numpy(dtype=np.float64)


def above_limit(limit_s: float) -> Figure:
    """The share of patients with more discomfort than a limit, s in 30 s."""
    title = f"above {limit_s:g} s of discomfort in {PER_S:g} s, % of patients"
    return Figure(title, lambda rows: (per_30_s(rows) > limit_s).astype(np.float64), "lower", scale=100.0)


def time_to(target: float) -> str:
    """Name of the time until the worst sd is at a target."""
    return f"time_to_{100.0 * target:g}"


def reaches(target: float) -> str:
    """Name of the share of patients whose worst sd comes to a target."""
    return f"reaches_{100.0 * target:g}"


def _of_target(target: float) -> dict[str, Figure]:
    column, percent = f"time_to_{target:g}_s", f"{100.0 * target:g} %"
    return {
        time_to(target): Figure(f"time to {percent}, s", _column(column), "lower", "median"),
        f"{time_to(target)}_p90": Figure(f"time to {percent}, p90, s", _column(column), "lower", "p90"),
        reaches(target): Figure(f"reach {percent}, % of patients", _reached(column), "higher", scale=100.0),
    }


FIGURES: Mapping[str, Figure] = MappingProxyType(
    {
        "information_true": Figure("true information, nats", _column("information_true"), "higher"),
        "information_claimed": Figure("claimed information, nats", _column("information_claimed"), "higher"),
        "information_bound": Figure("bound on information, nats", _column("information_bound"), "higher", bound=True),
        "honesty_gap": Figure("claimed − true, nats", _column("honesty_gap"), 0.0),
        "nees": Figure("NEES", _column("nees"), narrow="NEES\ncalibrated: {parameters}"),
        "nees_per_parameter": Figure("NEES / p", _per_parameter("nees"), 1.0, digits=2),
        "nees_prior": Figure("NEES of the prior", _column("nees_prior")),
        **{
            f"inside_{sigmas}_sigma": Figure(
                f"inside {sigmas} sd, %", _column(f"inside_{sigmas}_sigma"), expected, scale=100.0
            )
            for sigmas, expected in SIGMAS.items()
        },
        "worst_sd": Figure("worst sd, %", _column("worst_sd"), "lower", "median", 100.0, 2),
        "median_sd": Figure("median sd of the parameters, %", _median_sd, "lower", "median", 100.0, 2),
        "early_worst_sd": Figure("worst sd after 10 s, %", _column("early_worst_sd"), "lower", "median", 100.0, 2),
        "worst_sd_p90": Figure("worst sd, p90, %", _column("worst_sd"), "lower", "p90", 100.0, 2),
        "worst_sd_max": Figure("worst sd, largest, %", _column("worst_sd"), "lower", "largest", 100.0, 2),
        "early_worst_sd_p90": Figure(
            "worst sd after 10 s, p90, %", _column("early_worst_sd"), "lower", "p90", 100.0, 2
        ),
        "early_information_true": Figure(
            "true information after 10 s, nats", _column("early_information_true"), "higher"
        ),
        "early_nees_per_parameter": Figure("NEES / p after 10 s", _per_parameter("early_nees"), 1.0, digits=2),
        "early_rmse": Figure("RMSE after 10 s, %", _column("early_rmse"), "lower", scale=100.0),
        "worst_bound_sd": Figure(
            "worst sd of the bound, %", _column("worst_bound_sd"), "lower", "median", 100.0, 2, bound=True
        ),
        "rmse": Figure("RMSE, %", _column("rmse"), "lower", scale=100.0),
        "rmse_over_bound": Figure(
            "RMSE / bound", _of_parameters("error", "bound_sd"), 1.0, "ratio", 1.0, 2, "RMSE /\nbound", bound=True
        ),
        "identified": Figure("parameters known", _column("identified"), "higher", narrow="known\nof {parameters}"),
        **{name: figure for target in TARGETS for name, figure in _of_target(target).items()},
        "discomfort_s": Figure("discomfort, s", _column("discomfort_s"), "lower", digits=3),
        "discomfort_rate": Figure(
            f"discomfort, s per {PER_S:g} s",
            _columns("discomfort_s", "duration_s"),
            "lower",
            "rate",
            digits=2,
            narrow=f"discomfort\ns per {PER_S:g} s",
        ),
        "above_limit": above_limit(ADMITTED_S),
        "violated": Figure(
            "violating episodes, %", _column("violated"), "lower", scale=100.0, narrow="violating\nepisodes, %"
        ),
        "rings": Figure("alarm rings, % of episodes", _rings, "lower", scale=100.0, narrow="alarm\nrings, %"),
        "governor": Figure("governor, % of the time", _column("governor"), "lower", scale=100.0, narrow="governor\n%"),
    }
)
"""Every figure by its name."""
