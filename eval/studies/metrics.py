"""The figures that a study may be judged by."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
import numpy.typing as npt
import pandas as pd

from jawenv.metrics import alarm_rings

Array = npt.NDArray[np.float64]
ADMITTED_S = 0.1
"""Of discomfort in 30 s."""
Better = Literal["higher", "lower"]


@dataclass(frozen=True)
class Metric:
    """One figure per patient, and how it is summed up."""

    title: str  # heading of its column, with its unit
    of: Callable[[pd.DataFrame, int], Array]  # its values (N,) from the rows of N patients and the number of parameters
    better: Better | None  # which direction is better; None where neither is
    statistic: Literal["mean", "median", "p90"] = "mean"
    """Over the patients: their mean, or, where some may be infinite, their median or 90 % quantile (`p90`)."""
    scale: float = 1.0  # factor in tables
    digits: int = 1  # behind the point in tables


def _column(name: str) -> Callable[[pd.DataFrame, int], Array]:
    return lambda rows, parameters: rows[name].to_numpy(dtype=np.float64)


def _reached(name: str) -> Callable[[pd.DataFrame, int], Array]:
    return lambda rows, parameters: np.isfinite(rows[name].to_numpy(dtype=np.float64)).astype(np.float64)


def _per_parameter(name: str) -> Callable[[pd.DataFrame, int], Array]:
    return lambda rows, parameters: rows[name].to_numpy(dtype=np.float64) / parameters


def _median_sd(rows: pd.DataFrame, parameters: int) -> Array:
    """Of the parameters that the model has."""
    sds = rows[[name for name in map(str, rows) if name.startswith("sd/")]].to_numpy(dtype=np.float64)
    median: Array = np.nanmedian(sds, axis=1)
    return median


def _above_limit(rows: pd.DataFrame, parameters: int) -> Array:
    per_30_s = 30.0 * (rows["discomfort_s"] / rows["duration_s"]).to_numpy(dtype=np.float64)
    above: Array = (per_30_s > ADMITTED_S).astype(np.float64)
    return above


def _rings(rows: pd.DataFrame, parameters: int) -> Array:
    return alarm_rings(rows["misfit"].to_numpy(dtype=np.float64)).astype(np.float64)


METRICS: Mapping[str, Metric] = MappingProxyType(
    {
        "information_true": Metric("true information, nats", _column("information_true"), "higher"),
        "information_claimed": Metric("claimed information, nats", _column("information_claimed"), "higher"),
        "information_bound": Metric("bound on information, nats", _column("information_bound"), "higher"),
        "honesty_gap": Metric("claimed − true, nats", _column("honesty_gap"), None),
        "nees_per_parameter": Metric("NEES / p", _per_parameter("nees"), None, digits=2),
        "inside_1_sigma": Metric("inside 1 sd, %", _column("inside_1_sigma"), None, scale=100.0),
        "inside_2_sigma": Metric("inside 2 sd, %", _column("inside_2_sigma"), None, scale=100.0),
        "inside_3_sigma": Metric("inside 3 sd, %", _column("inside_3_sigma"), None, scale=100.0),
        "worst_sd": Metric("worst sd, %", _column("worst_sd"), "lower", "median", 100.0, 2),
        "median_sd": Metric("median sd of the parameters, %", _median_sd, "lower", "median", 100.0, 2),
        "early_worst_sd": Metric("worst sd after 10 s, %", _column("early_worst_sd"), "lower", "median", 100.0, 2),
        "worst_sd_p90": Metric("worst sd, p90, %", _column("worst_sd"), "lower", "p90", 100.0, 2),
        "early_worst_sd_p90": Metric(
            "worst sd after 10 s, p90, %", _column("early_worst_sd"), "lower", "p90", 100.0, 2
        ),
        "early_information_true": Metric(
            "true information after 10 s, nats", _column("early_information_true"), "higher"
        ),
        "early_nees_per_parameter": Metric("NEES / p after 10 s", _per_parameter("early_nees"), None, digits=2),
        "early_rmse": Metric("RMSE after 10 s, %", _column("early_rmse"), "lower", scale=100.0),
        "worst_bound_sd": Metric("worst sd of the bound, %", _column("worst_bound_sd"), "lower", "median", 100.0, 2),
        "rmse": Metric("RMSE, %", _column("rmse"), "lower", scale=100.0),
        "identified": Metric("parameters known", _column("identified"), "higher"),
        "time_to_10": Metric("time to 10 %, s", _column("time_to_0.1_s"), "lower", "median"),
        "time_to_5": Metric("time to 5 %, s", _column("time_to_0.05_s"), "lower", "median"),
        "time_to_2": Metric("time to 2 %, s", _column("time_to_0.02_s"), "lower", "median"),
        "time_to_5_p90": Metric("time to 5 %, p90, s", _column("time_to_0.05_s"), "lower", "p90"),
        "reaches_5": Metric("reach 5 %, % of patients", _reached("time_to_0.05_s"), "higher", scale=100.0),
        "discomfort_s": Metric("discomfort, s", _column("discomfort_s"), "lower", digits=3),
        "above_limit": Metric(
            f"above {ADMITTED_S} s of discomfort in 30 s, % of patients", _above_limit, "lower", scale=100.0
        ),
        "violated": Metric("violating episodes, %", _column("violated"), "lower", scale=100.0),
        "rings": Metric("alarm rings, % of episodes", _rings, "lower", scale=100.0),
        "governor": Metric("governor, % of the time", _column("governor"), "lower", scale=100.0),
    }
)
"""Every figure by its name; sd are of natural logs, so 5 % is 5 % of the parameter."""
COMPARED = {name for name, metric in METRICS.items() if metric.statistic != "p90"}
"""Metrics with differences patient by patient; a quantile's would repeat the median's."""
DEFAULT_METRICS = ("information_true", "worst_sd", "time_to_5", "nees_per_parameter", "discomfort_s")
