"""Estimates as rows of a table: one per case, time and parameter."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from eval.figures import statistics, words
from eval.figures.statistics import Interval
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


def of_logs(logs: Array, record: Record, case: str) -> pd.DataFrame:
    """Rows of estimated natural logs (p,) of the parameters of a simulated record.

    ``truth`` and ``estimate`` are natural logs; ``true_value`` and ``value`` are F_o (N) and b themselves.
    """
    truth = truth_of(record)
    values = {"truth": truth, "estimate": logs, "true_value": np.exp(truth), "value": np.exp(logs)}
    return pd.DataFrame({"case": case, "parameter": record.parameter_names, **values})


def of_estimate(estimate: Estimate, record: Record, case: str, times: int = 1) -> pd.DataFrame:
    """Rows of ``times`` kept times, evenly spread, or of the last: those of `of_logs`, ``sd``, and NEES of all."""
    picked = np.unique(np.linspace(0, len(estimate.time) - 1, times).astype(int)) if times > 1 else [-1]
    return pd.concat(
        of_logs(estimate.mean[k], record, case).assign(
            time_s=estimate.time[k], sd=estimate.sd[k], nees=nees(estimate.mean[k] - truth_of(record), estimate.cov[k])
        )
        for k in picked
    )


def truth_of(record: Record) -> Array:
    """(p,) true natural-log parameters of a simulated record."""
    assert record.truth is not None, "a simulated record has its truth"
    return record.truth


def nees(error: Array, cov: Array) -> float:
    """Squared error in units of the covariance; NaN where the estimator has none."""
    if not (np.isfinite(error).all() and np.isfinite(cov).all()):
        return float("nan")
    try:
        return float(error @ np.linalg.solve(cov, error))
    except np.linalg.LinAlgError:
        return float("nan")


def last(table: pd.DataFrame) -> pd.DataFrame:
    """Rows at the end of each case."""
    return table[table["time_s"] == table.groupby("case")["time_s"].transform("max")]


def percent(estimate: Interval) -> Interval:
    """A share in percent."""
    return words.scaled(estimate, 100.0)


def alone(value: float) -> Interval:
    """A figure without an interval."""
    return Interval(value, value, value)


def over_draws(table: pd.DataFrame, column: str) -> Interval:
    """Median over the draws of the largest value in each; infinite where there is none."""
    return statistics.quantile(table.groupby("draw")[column].max().fillna(np.inf).to_numpy(), 0.5)


def spreads(table: pd.DataFrame) -> pd.DataFrame:
    """``truth``, and ``mean`` and ``sd`` of the estimates, of each parameter: F_o (N) or b.

    ``bias`` is relative, ``bias_sds`` in sds of a single estimate, and ``inside`` whether the truth lies within one sd.
    """
    of = table.groupby("parameter", sort=False)
    found = pd.DataFrame({"truth": of["true_value"].first(), "mean": of["value"].mean(), "sd": of["value"].std(ddof=1)})
    off = found["mean"] - found["truth"]
    return found.assign(bias=off / found["truth"], bias_sds=off / found["sd"], inside=off.abs() <= found["sd"])


def of_case(table: pd.DataFrame, case: str) -> pd.DataFrame:
    """Rows of a case."""
    return table[table["case"] == case]


def kind(table: pd.DataFrame, symbol: str) -> pd.DataFrame:
    """Rows of the parameters ``log_F_o`` or ``log_b``."""
    return table[table["parameter"].str.startswith(f"{symbol}/")]


def rmse(table: pd.DataFrame) -> Interval:
    """Root mean square error of the logs over parameters, median over draws; infinite where an estimate is missing."""
    squares = (table["estimate"] - table["truth"]) ** 2
    mean = squares.fillna(np.inf).groupby(table["draw"]).mean()
    return statistics.quantile(np.sqrt(mean.to_numpy()), 0.5)
