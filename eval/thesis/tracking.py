"""Estimates over time: against the truth, and their errors against 3 sigma."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from eval.figures import words
from eval.report import drawing
from eval.thesis import rows

COLOURS = ("#3b82c4", "#e08a2c", "#3a9d5d", "#8b6cc6")
DRAWN = 40
_TRUTH = "#c25b4e"


def _name(parameter: str) -> str:
    return f"{'F_o, N' if parameter.startswith('log_F_o') else 'b'}  {words.muscle(parameter)}"


def _track(axes: Axes, estimates: pd.DataFrame, colour: str) -> None:
    """Estimate and three sds of one parameter in one draw, in F_o (N) or b."""
    mean, sd = estimates["estimate"].to_numpy(), estimates["sd"].to_numpy()
    truth = float(np.exp(estimates["truth"].iloc[0]))
    with np.errstate(over="ignore"):
        low, high = np.exp(mean - 3.0 * sd), np.exp(mean + 3.0 * sd)
    axes.fill_between(estimates["time_s"], low, high, color=colour, alpha=0.22, linewidth=0)
    axes.plot(estimates["time_s"], np.exp(mean), color=colour)
    axes.axhline(truth, color=_TRUTH, linestyle=(0, (4, 2)), linewidth=1.2)
    values = np.exp(mean)[np.isfinite(mean)]
    top = max(2.2 * truth, 1.1 * float(values.max(initial=0.0)))
    axes.set_ylim(0.0, min(top, 5.0 * truth))


def tracking(table: pd.DataFrame, case: str, columns: int) -> Figure:
    """Every parameter of the first draw over time."""
    first = rows.of_case(table[table["draw"] == table["draw"].min()], case)
    names = list(dict.fromkeys(first["parameter"]))
    lines = int(np.ceil(len(names) / columns))
    with drawing.style():
        figure = Figure(figsize=(10.2, 0.4 + 1.6 * lines), layout="constrained")
        grid = figure.subplots(lines, columns, sharex=True)
        for axes, name in zip(np.ravel(grid), names, strict=True):
            _track(axes, first[first["parameter"] == name], COLOURS[0] if "F_o" in name else COLOURS[1])
            axes.set_title(_name(name), fontsize=8)
        for axes in grid[-1]:
            axes.set_xlabel("s")
        return figure


def errors_with_bounds(table: pd.DataFrame, cases: Mapping[str, str]) -> Figure:
    """First case tracked in the first draw; errors of every case against 3 sigma, one row of panels each."""
    names = list(dict.fromkeys(table["parameter"]))
    first = table[table["draw"] == table["draw"].min()]
    with drawing.style():
        figure = Figure(figsize=(10.2, 1.95 * (1 + len(cases))), layout="constrained")
        grid = figure.subplots(1 + len(cases), len(names), sharex=True)
        for axes, name in zip(grid[0], names, strict=True):
            _track(axes, rows.of_case(first, next(iter(cases)), name), COLOURS[0])
            axes.set_title(_name(name), fontsize=8.5)
        for line, (case, label) in zip(grid[1:], cases.items(), strict=True):
            for axes, name in zip(line, names, strict=True):
                _errors(axes, rows.of_case(table, case, name))
            line[0].set_ylabel(f"error of the log,\n{label}", fontsize=7.5)
        for axes in grid[-1]:
            axes.set_xlabel("s")
        return figure


def _errors(axes: Axes, estimates: pd.DataFrame) -> None:
    for _, single in list(estimates.groupby("draw"))[:DRAWN]:
        axes.plot(
            single["time_s"], single["estimate"] - single["truth"], color=drawing.REFERENCE, linewidth=0.6, alpha=0.7
        )
    bound = 3.0 * estimates.groupby("time_s")["sd"].median()
    for sign in (-1.0, 1.0):
        axes.plot(bound.index, sign * bound, color=COLOURS[0], linewidth=1.5)
    later = bound[bound.index >= 0.1 * bound.index.max()]
    reach = 1.6 * float(later.max()) if len(later) and np.isfinite(later.max()) else 1.0
    axes.set_ylim(-reach, reach)


def noise_figure(table: pd.DataFrame, cases: Sequence[str]) -> Figure:
    """Root mean square error over the parameters and the sd that is claimed, median over the draws, per case."""
    with drawing.style():
        figure = Figure(figsize=(10.2, 2.7), layout="constrained")
        for axes, case in zip(figure.subplots(1, len(cases), sharey=True), cases, strict=True):
            estimates = rows.of_case(table, case)
            squares = estimates.assign(
                error=(estimates["estimate"] - estimates["truth"]) ** 2, variance=estimates["sd"] ** 2
            )
            mean = squares.groupby(["draw", "time_s"])[["error", "variance"]].mean().groupby("time_s").median() ** 0.5
            axes.plot(mean.index, mean["error"], color=COLOURS[1], label="error")
            axes.plot(mean.index, mean["variance"], color=COLOURS[0], linestyle=(0, (4, 2)), label="sd claimed")
            axes.set(title=f"noise: {case}", xlabel="s")
            drawing.log_percent(axes, ticks=(1, 2, 5, 10, 20, 50, 100))
        figure.axes[0].legend()
        return figure
