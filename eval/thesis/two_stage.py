"""Appendix A.4: the method that failed, and why."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, judged, one_by_one
from eval.thesis.methods.least_squares import nonlinear
from eval.thesis.methods.moment_balance import balance_of
from eval.thesis.methods.two_stage import exponents, two_stages
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import SENSORS, hinge_record, plane_record
from jawenv.recordings.record import Record

CLOSE = 0.1
RECORDS = {"one muscle": hinge_record, "three muscles": plane_record}
NOISY, PURE, SECOND, OTHER = "two stages", "two stages, no noise", "second stage, true F_o, no noise", "nonlinear"


def draw(rng: np.random.Generator) -> pd.DataFrame:
    """One muscle on a hinge and three in the plane, by the two-stage method, its parts, and nonlinear least squares."""
    tables = []
    for muscles, clean in RECORDS.items():
        record = with_noise(clean(), SENSORS, rng)
        for case, method, data in (
            (NOISY, two_stages, record),
            (PURE, two_stages, clean()),
            (OTHER, partial(nonlinear, starts=1), record),
        ):
            tables.append(rows.of_logs(method(data), data, f"{muscles}: {case}"))
        tables.append(_second_stage(clean(), f"{muscles}: {SECOND}"))
    return pd.concat(tables)


def _second_stage(record: Record, case: str) -> pd.DataFrame:
    """B by the second stage alone, given the true F_o and no noise: any error then lies in its formula."""
    values = np.exp(rows.truth_of(record))
    b = exponents(balance_of(record, rows="moment"), values[0::2])
    names = [name for name in record.parameter_names if name.startswith("log_b")]
    return pd.DataFrame({"case": case, "parameter": names, "true_value": values[1::2], "value": b})


def _relative_error(table: pd.DataFrame, case: str, symbol: str) -> float:
    """Median over draws and muscles of |estimate / truth - 1|; infinite where most have no value."""
    estimates = rows.kind(rows.of_case(table, case), symbol)
    error = (estimates["value"] / estimates["true_value"] - 1.0).abs().fillna(np.inf)
    return float(np.median(error))


def judge(table: pd.DataFrame) -> Judgement:
    """Fails with several muscles, with noise and without; its second stage is exact with one."""
    figures = {
        f"error of {symbol}, {case}, %": rows.alone(100.0 * _relative_error(table, case, f"log_{symbol}"))
        for case in dict.fromkeys(table["case"])
        for symbol in ("F_o", "b")
        if symbol == "b" or SECOND not in case
    }
    fails = figures[f"error of b, three muscles: {NOISY}, %"].value > 100.0 * CLOSE
    return judged(fails, False, figures)


ITEM = Item(
    "two_stage",
    "The failed two-stage method",
    "Appendix A.4",
    "F_o from small openings, where the force is taken as constant, then b from the logarithm of the moment: a “failed "
    f"method”. Why it failed is not said. {NO_NUMBER}",
    "One muscle on a hinge, and the three of Fig. 6.4 in the plane; both stages from one recording to 25°.",
    one_by_one(draw),
    judge,
)
