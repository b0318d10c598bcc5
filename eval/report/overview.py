"""The figure of a study for notebooks and for paper."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from eval.comparison.ranking import Ranking
from eval.comparison.results import Results
from eval.figures import words
from eval.figures.statistics import Interval
from eval.report import drawing
from eval.report.drawing import INK, REFERENCE


def overview(study: Results, ranking: Ranking) -> Figure:
    """True information with its interval, and the worst sd of every patient."""
    with drawing.style():
        return _overview(study, ranking)


def _overview(study: Results, ranking: Ranking) -> Figure:
    height = 1.0 + 0.36 * len(ranking.rows)
    figure = Figure(figsize=(9.6, height), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
    colour = drawing.colours(ranking)
    rng = np.random.default_rng(0)
    floor = drawing.floor(ranking)
    for y, row in enumerate(ranking.rows):
        _bar(left, row["information_true"], y, colour[row.entry], floor)
        left.plot(row["information_claimed"].value, y, "d", mfc="none", mec=colour[row.entry], ms=6)
        left.plot(row["information_bound"].value, y, "|", color=REFERENCE, ms=13, mew=1.6)
        worst = study.of(row.entry)["worst_sd"].to_numpy()
        shaken = y + rng.uniform(-0.24, 0.24, len(worst))
        right.scatter(worst, shaken, s=7, color=colour[row.entry], alpha=0.35, lw=0, rasterized=len(worst) > 200)
        _bar(right, row["worst_sd"], y, colour[row.entry])
        right.plot(row["worst_sd_p90"].value, y, "|", color=INK, ms=12, mew=1.6)
    left.plot([], [], "o", color=INK, label="true, with interval")
    left.plot([], [], "d", mfc="none", mec=INK, label="claimed")
    left.plot([], [], "|", color=REFERENCE, ms=11, mew=1.6, label="bound")
    right.plot([], [], "o", color=INK, label="median, with interval")
    right.plot([], [], "|", color=INK, ms=11, mew=1.6, label="90 % of patients")
    left.set(title="Information, nats (more is better)")
    right.set(title=f"Worst of the {ranking.n_parameters} sd (less is better)")
    drawing.log_percent(right, "x", ticks=(0.5, 1, 2, 3, 5, 10, 20, 30, 50, 100))
    drawing.entries_down(left, ranking)
    drawing.entries_down(right, ranking, labelled=False)
    for axes in (left, right):
        axes.legend(
            loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=2.6, ncols=3,
            handletextpad=0.3, columnspacing=1.2,
        )  # fmt: skip
    return figure


def _bar(axes: Axes, estimate: Interval, y: float, colour: str, floor: float = -np.inf) -> None:
    """A dot with its interval, or an arrow and a number at the floor for a value below it."""
    if estimate.value < floor:
        axes.plot(floor, y, "<", color=colour, ms=7, mec="none", zorder=3)
        axes.annotate(
            words.number(estimate.value, 0),
            (floor, y),
            xytext=(7, 0),
            textcoords="offset points",
            va="center_baseline",
        )
        return
    if estimate.known:
        ends = [max(estimate.low, floor), estimate.high]
        axes.plot(ends, [y, y], color=colour, lw=2.6, solid_capstyle="butt")
    axes.plot(estimate.value, y, "o", color=colour, ms=6.5, mec="white", mew=0.8, zorder=3)
