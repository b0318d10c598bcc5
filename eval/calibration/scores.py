"""Scores and tests of probabilistic forecasts: CRPS, energy score, PIT and expected coverage, as a table."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd
from scipy.special import ndtr
from scipy.stats import chi2, kstest, kstwo
from scoringrules import crps_normal

from eval.figures import statistics, words
from eval.figures.statistics import UNKNOWN, Interval

NOMINAL = (0.5, 0.8, 0.95, 0.99)
NOTE = (
    "CRPS: continuous ranked probability score of the log-parameters, mean over the parameters; energy score: the "
    "same of all parameters together (Gneiting & Raftery 2007); lower is better. PIT deviation: of the probability "
    "integral transforms from a uniform distribution (Kolmogorov–Smirnov), of the parameter where it is largest. If "
    "the filter is calibrated, it is below the limit for all parameters at once with 95 %. Coverage: share of the "
    "patients whose parameters lie together in the belief's ellipsoid of that probability."
)


def summarised(judged: pd.DataFrame, parameters: Sequence[str]) -> dict[str, object]:
    """Scores of one maneuver, filter and time, over the patients with a belief.

    Args:
        judged: rows of `eval.rows.beliefs.Beliefs` with that outcome.
        parameters: names.
    """
    if not len(judged):
        nothing = dict.fromkeys(["pit_deviation", "pit_limit", *map(_covered, NOMINAL)], float("nan"))
        return UNKNOWN.columns("crps") | UNKNOWN.columns("energy") | nothing | {"pit_deviation_of": ""}
    error, sd = (judged[[f"{kind}/{name}" for name in parameters]].to_numpy() for kind in ("error", "sd"))
    deviations = [float(kstest(column, "uniform").statistic) for column in ndtr(-error / sd).T]
    together = chi2.cdf(judged["nees"], len(parameters))
    return {
        **statistics.mean(crps_normal(0.0, error, sd).mean(axis=1)).columns("crps"),
        **statistics.mean(judged["energy"].to_numpy()).columns("energy"),
        "pit_deviation": max(deviations),
        "pit_deviation_of": parameters[int(np.argmax(deviations))],
        "pit_limit": float(kstwo.isf((1.0 - statistics.CONFIDENCE) / len(parameters), len(judged))),  # Bonferroni
        **{_covered(level): float(np.mean(together <= level)) for level in NOMINAL},
    }


def _covered(level: float) -> str:
    return f"covered_{100.0 * level:g}"


def _score(row: pd.Series, name: str) -> str:
    return words.with_interval(words.scaled(Interval.of(row, name), 100.0), 2)


def _deviation(row: pd.Series) -> str:
    """A cell such as `0.061 (0.097), b of masseter left`."""
    if not row["pit_deviation_of"]:
        return words.NOTHING
    deviation, limit = (words.number(row[name], 3) for name in ("pit_deviation", "pit_limit"))
    return f"{deviation} ({limit}), {words.parameter(row['pit_deviation_of'])}"


COLUMNS: Mapping[str, Callable[[pd.Series], str]] = {
    "CRPS, %": partial(_score, name="crps"),
    "energy score, %": partial(_score, name="energy"),
    "largest PIT deviation (limit)": _deviation,
    f"coverage at {' / '.join(words.percent(level, 0) for level in NOMINAL)} %": lambda row: " / ".join(
        words.percent(row[_covered(level)], 0) for level in NOMINAL
    ),
}
"""Texts of a summary's row by their headings."""
