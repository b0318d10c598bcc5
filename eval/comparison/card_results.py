"""Results of one entry of a comparison, for the model card of a policy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from eval.comparison.results import Results, load
from eval.figures import statistics
from eval.figures.catalogue import FIGURES
from eval.figures.statistics import Interval
from eval.rows.outcomes import EARLY_S
from jawenv.base.errors import InputError
from jawenv.playing.policies.card import Result

DECIMALS = 3


def card_results(results: Results, entry: str) -> tuple[Result, ...]:
    """Worst sd after 10 s and at the end (medians), true information, discomfort and NEES (means), with intervals.

    Args:
        results: of a comparison.
        entry: its label there.
    """
    if entry not in results.entries:
        raise InputError(f"entry {entry!r}: not in this comparison; allowed: {', '.join(results.entries)}")
    patients = results.of(entry)
    if len(patients) < 2:
        raise InputError(f"entry {entry!r}: an interval takes 2 patients or more, it was played on {len(patients)}")
    common = {
        "cohort": str(results.about["settings"]["cohort"]),
        "patients": len(patients),
        "seeds": (int(patients["seed"].min()), int(patients["seed"].max())),
        "level": statistics.CONFIDENCE,
    }
    return tuple(
        Result(
            metric=metric,
            low=round(interval.low, DECIMALS),
            high=round(interval.high, DECIMALS),
            **{kind: round(interval.value, DECIMALS)},
            **common,
        )
        for metric, kind, interval in _figures(results, entry)
    )


def results_of_run(folder: Path, run: Path) -> tuple[Result, ...]:
    """The figures of a training run in a finished comparison.

    Args:
        folder: of the comparison.
        run: folder of the run, one of its entries.
    """
    results = load(folder)
    places = {Path(each["spec"]).resolve(): each["label"] for each in results.about["entries"] if each.get("trained")}
    if run.resolve() not in places:
        raise InputError(f"{run}: not in this comparison; allowed: {', '.join(map(str, places)) or 'none'}")
    return card_results(results, places[run.resolve()])


def _figures(results: Results, entry: str) -> Iterator[tuple[str, str, Interval]]:
    """Metric, mean or median, and the interval."""
    rows, parameters = results.of(entry), len(results.parameters)
    end = f"{results.about['settings']['episode_s']:g} s"
    largest = "largest sd asked for" if "asked" in results.about["settings"] else f"largest of {parameters} sds"
    titles = {
        "early_worst_sd": f"{largest} after {EARLY_S:g} s, %",
        "worst_sd": f"{largest} after {end}, %",
        "information_true": f"true information after {end}, nats",
        "discomfort_s": f"discomfort in {end}, s",
        "nees": f"NEES after {end}, {parameters} if calibrated",
    }
    if titles["early_worst_sd"] == titles["worst_sd"]:
        del titles["early_worst_sd"]
    for name, title in titles.items():
        figure = FIGURES[name]
        if figure.statistic == "mean" or np.isfinite(figure.of(rows)).all():
            yield title, figure.statistic, figure.scaled(figure.interval(rows))
