"""Section 7.1: small openings do not tell b, and moving to the sides helps."""

from __future__ import annotations

import numpy as np
import pandas as pd

from eval.figures import words
from eval.figures.statistics import Interval
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, one_by_one
from eval.thesis.methods.least_squares import NonlinearLeastSquares
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import DEVICE, maneuver_record
from jawenv.references.extended_kalman import ExtendedKalman

OPENINGS = (5.0, 10.0, 20.0)
SMALL, LARGE = 5.0, 20.0
DECIDES = 2.0  # times the error of b, from a small opening to a large one: less is no matter of the opening's size
METHODS: dict[str, NonlinearLeastSquares | ExtendedKalman] = {
    "least squares": NonlinearLeastSquares(starts=1, use_prior=True),
    "filter": ExtendedKalman("log"),
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
                tables.append(rows.of_estimate(method.estimate(record), record, _case(degrees, to_the_side, name)))
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
    prior_F = float(np.sqrt(np.mean(maneuver_record(SMALL, False).prior.sd[::2] ** 2)))

    text = rows.with_interval

    return Judgement(
        f"Error of b after 5° of opening {text(b[SMALL, False])}, after 20° {text(b[LARGE, False])}; before anything "
        f"is measured the sd is {words.percent(prior_b, 0)} %. With swings {text(b[SMALL, True])} and "
        f"{text(b[LARGE, True])}. Error of F_o after 5° straight {text(force)}, of {words.percent(prior_F, 0)} % "
        f"before. Of all 12 after 20°: straight {text(both[False])}, with swings {text(both[True])}. All this by "
        "nonlinear least squares with the prior; by the extended Kalman filter, straight, b is off by "
        f"{text(filtered[SMALL])} after 5° and {text(filtered[LARGE])} after 20°.",
        "reproduced" if poor and decides and unknown and helps else "partly" if poor or helps else "not reproduced",
        ("Small openings tell less of b" if poor else "Small openings tell b as well as large ones")
        + (
            ""
            if not poor
            else ", but straight ones of any size leave much of it open"
            if not decides
            else ", and leave more than half of what was not known before"
            if unknown
            else ", but still far more than was known before"
        )
        + (
            "; swings to the side help"
            + (" more than the size of the opening." if b[SMALL, True].high < b[LARGE, False].low else ".")
            if helps
            else "; swings to the side do not help measurably."
        ),
        {
            "b_small": b[SMALL, False].value,
            "b_large": b[LARGE, False].value,
            "F_o_small": force.value,
            "all_straight": both[False].value,
            "all_swings": both[True].value,
        },
    )


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
