"""The figures of a study for notebooks and for paper; each function returns a matplotlib Figure."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from eval import words
from eval.comparison.ranking import SIGMAS, Ranking
from eval.comparison.results import Results
from eval.report import drawing, panels
from eval.report.drawing import BAND, INK, REFERENCE
from eval.statistics import Interval

P = ParamSpec("P")


def _styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with drawing.style():
            return draw(*args, **kwargs)

    return drawn


@_styled
def overview(study: Results, ranking: Ranking) -> Figure:
    """True information with its interval, and the worst sd of every patient."""
    height = 1.0 + 0.36 * len(ranking.rows)
    figure = Figure(figsize=(9.6, height), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
    colour = drawing.colours(ranking)
    rng = np.random.default_rng(0)
    floor = _floor(ranking)
    for place, row in enumerate(ranking.rows):
        _bar(left, row.information_true, place, colour[row.entry], floor)
        left.plot(row.information_claimed.value, place, "d", mfc="none", mec=colour[row.entry], ms=6)
        left.plot(row.information_bound.value, place, "|", color=REFERENCE, ms=13, mew=1.6)
        worst = study.of(row.entry)["worst_sd"].to_numpy()
        shaken = place + rng.uniform(-0.24, 0.24, len(worst))
        right.scatter(worst, shaken, s=7, color=colour[row.entry], alpha=0.35, lw=0, rasterized=len(worst) > 200)
        _bar(right, row.worst_sd_median, place, colour[row.entry])
        right.plot(row.worst_sd_p90.value, place, "|", color=INK, ms=12, mew=1.6)
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


def _bar(axes: Axes, estimate: Interval, place: float, colour: str, floor: float = -np.inf) -> None:
    """A dot with its interval, or an arrow and a number at the floor for what lies below it."""
    if estimate.value < floor:
        axes.plot(floor, place, "<", color=colour, ms=7, mec="none", zorder=3)
        axes.annotate(
            words.number(estimate.value, 0),
            (floor, place),
            xytext=(7, 0),
            textcoords="offset points",
            va="center_baseline",
        )
        return
    if estimate.known:
        ends = [max(estimate.low, floor), estimate.high]
        axes.plot(ends, [place, place], color=colour, lw=2.6, solid_capstyle="butt")
    axes.plot(estimate.value, place, "o", color=colour, ms=6.5, mec="white", mew=0.8, zorder=3)


def _floor(ranking: Ranking) -> float:
    """True information below which an entry is not drawn to scale: a single liar would flatten all others."""
    return -0.1 * max(row.information_claimed.value for row in ranking.rows)


@_styled
def sd_over_time(study: Results, ranking: Ranking) -> Figure:
    """Median sd of every parameter over time, all entries."""
    head = drawing.legend_height(ranking)
    figure = Figure(figsize=(9.6, panels.height(study, head)))
    grid = panels.grid(figure, study, head)
    colour, dash = drawing.colours(ranking), drawing.dashes(ranking)
    for parameter, axes in grid.items():
        for row in reversed(ranking.rows):
            time, curve = _curve(study, row.entry, f"sd/{parameter}")
            width = 2.2 if row.trained else 1.3
            axes.plot(time, curve["centre"], color=colour[row.entry], ls=dash[row.entry], lw=width)
    drawing.legend_above(figure, ranking)
    return figure


def _curve(study: Results, entry: str, quantity: str, points: int = 90) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """One curve, thinned to what a small panel can show."""
    curves = study.curves
    table = curves[(curves["entry"] == entry) & (curves["quantity"] == quantity)]
    picked = np.unique(np.linspace(0, len(table) - 1, points).round().astype(int))
    thin = table.iloc[picked]
    return thin["time_s"].to_numpy(), {name: thin[name].to_numpy() for name in ("low", "centre", "high", "bound")}


@_styled
def calibration(study: Results, ranking: Ranking) -> Figure:
    """NEES against its band, coverage of 1, 2 and 3 sd, and claimed minus true information."""
    figure = Figure(figsize=(9.6, 0.9 + 0.34 * len(ranking.rows)), layout="constrained")
    left, *coverage, right = figure.subplots(1, 5, width_ratios=(1.3, 0.8, 0.8, 0.8, 1.1))
    colour = drawing.colours(ranking)
    left.axvspan(*ranking.band, color=BAND, alpha=0.45, lw=0)
    right.axvline(0.0, color=BAND, lw=4.0, alpha=0.6)
    for axes, (sigmas, share) in zip(coverage, SIGMAS.items(), strict=True):
        axes.axvline(100.0 * share, color=BAND, lw=4.0, alpha=0.6)
        axes.set(title=f"Within {sigmas} sd, %")
    for place, row in enumerate(ranking.rows):
        _bar(left, row.nees, place, colour[row.entry])
        _bar(right, row.honesty_gap, place, colour[row.entry])
        for axes, share_inside in zip(coverage, row.inside.values(), strict=True):
            _bar(axes, words.scaled(share_inside, 100.0), place, colour[row.entry])
    if max(row.nees.value for row in ranking.rows) > 5.0 * min(row.nees.value for row in ranking.rows):
        left.set_xscale("log")
    gaps = np.array([abs(row.honesty_gap.value) for row in ranking.rows])
    if gaps.max() > 10.0 * max(float(np.median(gaps)), 1.0):
        right.set_xscale("symlog", linthresh=5.0)
        right.xaxis.set_major_locator(FixedLocator([-100, 0, 10, 100, 1000, 10_000]))
    left.set(title="Mean NEES")
    right.set(title="Claimed − true, nats")
    drawing.entries_down(left, ranking)
    for axes in (*coverage, right):
        drawing.entries_down(axes, ranking, labelled=False)
    return figure
