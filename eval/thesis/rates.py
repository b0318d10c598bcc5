"""Section 7.3.2: from the simulation's high sampling rate down to a bench's."""

from __future__ import annotations

import numpy as np
import pandas as pd

from eval.figures import statistics, words
from eval.figures.statistics import Interval
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, one_by_one
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import DEVICE, TICK, sampled_record
from jawenv.recordings.thinning import divided
from jawenv.references.extended_kalman import ExtendedKalman

RATES = (200.0, 100.0, 50.0, 20.0, 10.0, 5.0)
FILTER = ExtendedKalman("log")
WORSE = 2.0  # times the error at the highest rate, or a calibrated NEES
HONEST = 11.34  # median of the chi-squared distribution with 12 degrees of freedom


def _case(hz: float, parts: int = 1) -> str:
    return f"{hz:g} Hz" + (", divided" if parts > 1 else "")


def _parts(hz: float) -> int:
    """Ticks of 10 ms in one of this rate."""
    return max(1, round(1.0 / (hz * TICK)))


def draw(rng: np.random.Generator) -> pd.DataFrame:
    """The same motion, sampled at each rate; where ticks are longer than 10 ms, with them divided as well."""
    tables = []
    for hz in RATES:
        record = with_noise(sampled_record(1.0 / hz), DEVICE, rng)
        for parts in sorted({1, _parts(hz)}):
            estimate = FILTER.estimate(divided(record, parts))
            tables.append(rows.of_estimate(estimate, record, _case(hz, parts)))
    return pd.concat(tables)


def _rates(table: pd.DataFrame) -> list[float]:
    return [hz for hz in RATES if _case(hz) in set(table["case"])]


def nees(table: pd.DataFrame, case: str) -> Interval:
    """Median over the draws; 12 is calibrated."""
    values = rows.of_case(table, case).groupby("draw")["nees"].first()
    return statistics.quantile(values.fillna(np.inf).to_numpy(), 0.5)


def _figures(table: pd.DataFrame, hz: float, parts: int = 1) -> str:
    case = _case(hz, parts)
    error = _error(table, case)
    if not np.isfinite(error.value):
        return f"{_case(hz)} diverges"
    return f"{_case(hz)} {rows.with_interval(error)}, NEES {words.number(nees(table, case).value)}"


def _below(rates: list[float], poor: list[bool]) -> list[float]:
    """The lowest rates, as far up as all of them are poor."""
    good = [hz for hz, is_poor in zip(rates, poor, strict=True) if not is_poor]
    return [hz for hz in rates if not good or hz < min(good)]


def judge(table: pd.DataFrame) -> Judgement:
    """Judge the rates: some are too slow for the filter as it is."""
    rates = _rates(table)
    error = {hz: _error(table, _case(hz)) for hz in rates}
    failed = {hz: float(rows.of_case(table, _case(hz))["estimate"].isna().mean()) for hz in rates}
    best = error[rates[0]]
    slow = _below(rates, [error[hz].value > WORSE * best.value for hz in rates])
    sure = _below(rates, [nees(table, _case(hz)).value > WORSE * HONEST for hz in rates])
    short = [hz for hz in rates if _parts(hz) > 1]
    cases = dict.fromkeys(table["case"])
    return Judgement(
        "Error of the 12 parameters and median NEES (calibrated: 11.3): "
        f"{'; '.join(_figures(table, hz) for hz in rates)}. With ticks divided into 10 ms: "
        f"{'; '.join(_figures(table, hz, _parts(hz)) for hz in short)}.",
        "reproduced" if slow else "not reproduced",
        f"At {_case(max(slow))} and below the error is more than {WORSE:g} times that at {_case(rates[0])}"
        + (
            f", and at {_case(max(sure))} and below the NEES more than {WORSE:g} times that of calibrated error bars"
            if sure
            else ""
        )
        + ": the filter as it is has to be tuned, as the thesis says."
        if slow
        else f"Nothing has to be tuned down to {_case(min(rates))}.",
        {f"rmse/{case}": value for case in cases if np.isfinite(value := _error(table, case).value)}
        | {f"nees/{case}": value for case in cases if np.isfinite(value := nees(table, case).value)}
        | {f"diverged/{_case(hz)}": failed[hz] for hz in rates},
    )


def _error(table: pd.DataFrame, case: str) -> Interval:
    return rows.rmse(rows.of_case(table, case))


ITEM = Item(
    "rates",
    "Lower sampling rates",
    "Section 7.3.2",
    f"The algorithms work at a high sampling rate and have to be tuned for lower, realistic ones. {NO_NUMBER}",
    "One patient of cohort “trismus”, opening to 20° with swings of 4° to the sides, 20 s, every rate simulated for "
    "itself; what is not modelled is new every 10 ms, so its mean over a longer tick is smaller; extended Kalman "
    "filter in logs, untuned.",
    one_by_one(draw),
    judge,
)
