"""Figs. 6.3 to 6.8: least squares, linearised and not, three muscles in the plane and six in space."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from eval.figures import statistics, words
from eval.figures.statistics import Interval
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, judged, one_by_one
from eval.thesis.methods.least_squares import linear, nonlinear
from eval.thesis.methods.moment_balance import balance_of
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import DEVICE, SENSORS, full_record, plane_record
from jawenv.metrics import STIFF_F_O_N
from jawenv.recordings.record import Record

NOISES = {"sensors": SENSORS, "sensors and forces": DEVICE}
CLOSE = 0.1  # a mean this near to the truth, relative, is "close to the actual"


def _draw_linear(rng: np.random.Generator) -> pd.DataFrame:
    """Three muscles in the plane by linearised least squares; F_o may come out negative, so there may be no logs."""
    record = with_noise(plane_record(), SENSORS, rng)
    coefficients = linear(balance_of(record))
    force, slope = coefficients[0::2], coefficients[1::2]
    values = np.column_stack([force, slope / force]).ravel()
    return pd.DataFrame(
        {
            "case": "linear",
            "parameter": record.parameter_names,
            "true_value": np.exp(rows.truth_of(record)),
            "value": values,
        }
    )


def judge_linear(table: pd.DataFrame) -> Judgement:
    """A bias of b beyond three of its sds, which are small; none where F_o has either sign, and so b no mean."""
    fits = rows.spreads(table)
    biased = {
        name: fit
        for name, fit in fits[fits.index.str.startswith("log_b/")].iterrows()
        if np.isfinite(fit["bias_sds"]) and not _either_sign(table, str(name))
    }
    figures = _means(biased) | {
        f"bias of {words.parameter(str(name))}, sds": rows.alone(fit["bias_sds"]) for name, fit in biased.items()
    }
    negative = (rows.kind(table, "log_F_o")["value"] < 0.0).mean()
    figures["F_o that come out negative, %"] = rows.alone(100.0 * float(negative))
    return judged(max((abs(fit["bias_sds"]) for fit in biased.values()), default=0.0) > 3.0, False, figures)


def _means(fits: Mapping[Any, pd.Series]) -> dict[str, Interval]:
    """Means of parameters, with one sd to either side for the ends of an interval."""
    return {
        f"{words.parameter(str(name))} for {words.number(fit['truth'], 2)}, mean and one sd": Interval(
            fit["mean"], fit["mean"] - fit["sd"], fit["mean"] + fit["sd"]
        )
        for name, fit in fits.items()
    }


def _either_sign(table: pd.DataFrame, parameter: str) -> bool:
    """Whether F_o is negative in 1 to 99 % of the draws: b, a quotient by it, then has no mean."""
    force = parameter.replace("log_b/", "log_F_o/")
    negative = float((table.loc[table["parameter"] == force, "value"] < 0.0).mean())
    return 0.01 < negative < 0.99


def _nonlinear(clean: Record, rng: np.random.Generator) -> pd.DataFrame:
    """Nonlinear least squares with noise of the sensors, and with forces that no model explains on top."""
    tables = []
    for case, device in NOISES.items():
        record = with_noise(clean, device, rng)
        tables.append(rows.of_logs(nonlinear(record, 2), record, case))
    return pd.concat(tables)


def judge_plane(table: pd.DataFrame) -> Judgement:
    """Means close to the truth with the noise of the sensors."""
    fits = rows.spreads(rows.of_case(table, "sensors"))
    close, inside = (fits["bias"].abs() <= CLOSE).sum(), fits["inside"].sum()
    part = inside == len(fits) or 2 * close >= len(fits)
    return judged(close == len(fits), bool(part), _means(dict(fits.iterrows())) | _counts(table))


def _counts(table: pd.DataFrame) -> dict[str, Interval]:
    """Numbers of means near the truth, and the largest bias and sd, as figures."""
    fits = rows.spreads(rows.of_case(table, "sensors"))
    figures = {
        f"means within {100.0 * CLOSE:g} % of the truth, of {len(fits)}": (fits["bias"].abs() <= CLOSE).sum(),
        f"truths within one sd of the mean, of {len(fits)}": fits["inside"].sum(),
    }
    for case in NOISES:
        fits = rows.spreads(rows.of_case(table, case))
        figures[f"largest bias, noise of {case}, %"] = 100.0 * fits["bias"].abs().max()
        figures[f"largest sd, noise of {case}, %"] = 100.0 * (fits["sd"] / fits["truth"]).max()
    return {name: rows.alone(float(value)) for name, value in figures.items()}


def judge_full(table: pd.DataFrame) -> Judgement:
    """Mean near, truth within one sd of the mean, and no muscle classed wrongly."""
    inside = rows.spreads(rows.of_case(table, "sensors"))["inside"].all()
    wrong, _ = _wrongly_taken(table)
    figures = _counts(table) | {f"muscles on the wrong side of {STIFF_F_O_N:g} N by the mean": rows.alone(wrong)}
    return judged(bool(inside) and wrong == 0, wrong == 0, figures)


def _wrongly_taken(table: pd.DataFrame) -> tuple[int, Interval]:
    """Muscles with a mean F_o on the wrong side of the limit, and the share of such single fits."""
    forces = rows.kind(rows.of_case(table, "sensors"), "log_F_o")
    truly = forces["true_value"] > STIFF_F_O_N
    singly = statistics.share((truly != (forces["value"] > STIFF_F_O_N)).to_numpy())
    fits = rows.spreads(forces)
    return int(((fits["truth"] > STIFF_F_O_N) != (fits["mean"] > STIFF_F_O_N)).sum()), singly


def judge_physician(table: pd.DataFrame) -> Judgement:
    """Whether the stiff muscle, and no other, would be taken for stiff."""
    wrong, singly = _wrongly_taken(table)
    figures = {
        f"single fits on the wrong side of {STIFF_F_O_N:g} N, %": rows.percent(singly),
        "muscles there by the mean, of 6": rows.alone(wrong),
    }
    return judged(wrong == 0 and singly.value < 0.05, wrong == 0, figures)


_PLANE = (
    "Midline model held in the plane, the three pairs of muscles, F_o and b as in Fig. 6.4 with the second pair the "
    "other way round than printed; two openings to 25° in 30 s with the condyle led off its slide by up to 3 mm; "
    "noise of our device."
)

LINEAR = Item(
    "linear",
    "Linear least squares, 3 muscles",
    "Fig. 6.3; section 6.2",
    "The standard deviation of b is small while its mean has a large bias, “much larger than 3σ”. The histograms' "
    "numbers are not given in the text.",
    _PLANE,
    one_by_one(_draw_linear),
    judge_linear,
)
PLANE = Item(
    "nonlinear_plane",
    "Nonlinear least squares, 3 muscles",
    "Fig. 6.4; section 6.3.1",
    "“Even with large measurement noise, the mean of the values is close to that of the actual stiffness "
    "parameters”: F_o 0.25, b 8; F_o 6, b 0.25 (printed; we take 0.25 and 6); F_o 0.4, b 6. The noise is not given.",
    _PLANE,
    one_by_one(lambda rng: _nonlinear(plane_record(), rng)),
    judge_plane,
)
FULL = Item(
    "nonlinear_full",
    "Nonlinear least squares, 12 parameters",
    "Figs. 6.5, 6.6; section 6.4",
    "“The mean is relatively close to the actual value and the standard deviation captures the true value”, with no "
    f"false indication of a healthy or a sick muscle. {NO_NUMBER}",
    "Six muscles, the left masseter stiff (F_o 3 N, b 12), the others normal (0.4 N, 7); opening to 20° with swings "
    "of 4° to the sides, 20 s; search from the middle of the prior “wide”.",
    one_by_one(lambda rng: _nonlinear(full_record(), rng)),
    judge_full,
)
PHYSICIAN = Item(
    "physician_view",
    "Physician's view",
    "Figs. 6.7, 6.8; section 6.4",
    "Predicted values with a bound of one sd, and with a confidence radius, show the physician which muscle is stiff. "
    f"{NO_NUMBER}",
    "The same patient and maneuver as for the 12 parameters.",
    one_by_one(lambda rng: _nonlinear(full_record(), rng)),
    judge_physician,
    same_draws_as="nonlinear_full",
)
