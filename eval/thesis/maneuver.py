"""Section 7.1: small openings do not tell b, and moving to the sides helps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd

from eval.figures.statistics import Interval
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, judged, one_by_one
from eval.thesis.methods.least_squares import Array, nonlinear
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import DEVICE, maneuver_record
from jawenv.recordings.record import Record
from jawenv.references.extended_kalman import ExtendedKalman

OPENINGS = (5.0, 10.0, 20.0)
SMALL, LARGE = 5.0, 20.0
DECIDES = 2.0  # times the error of b, from a small opening to a large one: less is no matter of the opening's size
METHODS: dict[str, Callable[[Record], Array]] = {
    "least squares": partial(nonlinear, starts=1, use_prior=True),
    "filter": lambda record: ExtendedKalman("log").estimate(record).mean[-1],
}


def _case(degrees: float, to_the_side: bool, method: str) -> str:
    return f"{degrees:g}° {'with swings' if to_the_side else 'straight'}, {method}"


def draw(rng: np.random.Generator) -> pd.DataFrame:
    """Each opening with and without swings, by nonlinear least squares with the prior and by the filter in logs."""
    tables = []
    for degrees in OPENINGS:
        for to_the_side in (False, True):
            record = with_noise(maneuver_record(degrees, to_the_side), DEVICE, rng)
            for name, method in METHODS.items():
                tables.append(rows.of_logs(method(record), record, _case(degrees, to_the_side, name)))
    return pd.concat(tables)


def errors(
    table: pd.DataFrame, symbol: str, degrees: float, to_the_side: bool, method: str = "least squares"
) -> Interval:
    """Root mean square error of log F_o or log b, median over the draws."""
    return rows.rmse(rows.kind(rows.of_case(table, _case(degrees, to_the_side, method)), symbol))


def judge(table: pd.DataFrame) -> Judgement:
    """Error of b at small against large openings, of F_o at small ones, and straight against with swings."""
    b = {(d, s): errors(table, "log_b", d, s) for d in (SMALL, LARGE) for s in (False, True)}
    force = errors(table, "log_F_o", SMALL, False)
    both = {s: rows.rmse(rows.of_case(table, _case(LARGE, s, "least squares"))) for s in (False, True)}
    filtered = {d: errors(table, "log_b", d, False, "filter") for d in (SMALL, LARGE)}
    prior_b = float(np.sqrt(np.mean(maneuver_record(SMALL, False).prior.sd[1::2] ** 2)))
    poor = any(b[SMALL, aside].low > b[LARGE, aside].high for aside in (False, True))
    unknown = b[SMALL, False].value > 0.5 * prior_b
    decides = b[SMALL, False].value > DECIDES * b[LARGE, False].value
    helps = both[True].high < both[False].low
    figures = {
        f"error of b after {d:g}°{', with swings' if s else ''}, %": rows.percent(value) for (d, s), value in b.items()
    } | {
        "sd of b before, %": rows.alone(100.0 * prior_b),
        f"error of F_o after {SMALL:g}°, %": rows.percent(force),
        f"error of all 12 after {LARGE:g}°, %": rows.percent(both[False]),
        f"error of all 12 after {LARGE:g}°, with swings, %": rows.percent(both[True]),
        **{f"error of b by the filter after {d:g}°, %": rows.percent(value) for d, value in filtered.items()},
    }
    return judged(poor and decides and unknown and helps, poor or helps, figures)


ITEM = Item(
    "maneuver",
    "What the maneuver decides",
    "Section 7.1",
    "Maneuvers of less than 10° of opening give poor estimates of b, while F_o is easy to predict there; with more "
    f"muscles, moving the jaw left and right lets the algorithms converge sooner. {NO_NUMBER}",
    "One patient of cohort “trismus”, believed to be of the far wider “wide”; openings of 5° to 20° beyond rest in "
    "20 s, straight and with swings of 4° to the sides; nonlinear least squares with the prior, and extended Kalman "
    "filter in logs.",
    one_by_one(draw),
    judge,
)
