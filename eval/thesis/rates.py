"""Section 7.3.2: from the simulation's high sampling rate down to a bench's."""

from __future__ import annotations

import numpy as np
import pandas as pd

from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, judged, one_by_one
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import DEVICE, TICK, sampled_record
from jawenv.recordings.dividing import divided
from jawenv.references.extended_kalman import ExtendedKalman

RATES = (200.0, 100.0, 50.0, 20.0, 10.0, 5.0)
FILTER = ExtendedKalman("log")
WORSE = 2.0  # times the error at the highest rate


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


def judge(table: pd.DataFrame) -> Judgement:
    """Judge the lowest rate: whether it is too slow for the filter as it is."""
    rates = [hz for hz in RATES if _case(hz) in set(table["case"])]
    by_case = {case: rows.of_case(table, case) for case in dict.fromkeys(table["case"])}
    error = {case: rows.rmse(own) for case, own in by_case.items()}
    figures = {f"error at {case}, %": rows.percent(value) for case, value in error.items()}
    figures |= {
        f"median NEES at {case} (calibrated: 11.3)": rows.over_draws(own, "nees") for case, own in by_case.items()
    }
    slow = error[_case(min(rates))].value > WORSE * error[_case(max(rates))].value
    return judged(slow, False, figures)


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
