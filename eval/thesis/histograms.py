"""Histograms of estimates, and a physician's view of them."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from eval.figures import words
from eval.report import drawing

FORCE, EXPONENT = "#3b82c4", "#e08a2c"
FEWEST_IN_BINS = 20  # fewer values are drawn one by one
_SIDES = {"left": "#3b82c4", "right": "#8b6cc6"}


def histograms(table: pd.DataFrame, columns: int) -> Figure:
    """One panel per parameter: F_o (N) in one colour, b in another."""
    names = sorted(dict.fromkeys(table["parameter"]), key=lambda name: not name.startswith("log_F_o"))
    lines = int(np.ceil(len(names) / columns))
    with drawing.style():
        figure = Figure(figsize=(10.2, 0.3 + 1.75 * lines), layout="constrained")
        for axes, name in zip(np.ravel(figure.subplots(lines, columns)), names, strict=True):
            _histogram(axes, table[table["parameter"] == name], name)
        return figure


def _histogram(axes: Axes, rows: pd.DataFrame, name: str) -> None:
    values = rows["value"].to_numpy()
    values = values[np.isfinite(values)]
    truth = float(rows["true_value"].iloc[0])
    force = name.startswith("log_F_o")
    colour = FORCE if force else EXPONENT
    if 0 < len(values) < FEWEST_IN_BINS:
        axes.plot(values, np.linspace(0.2, 0.8, len(values)), "o", color=colour, markersize=5, alpha=0.75)
        axes.axvline(float(values.mean()), color=drawing.INK, linestyle=(0, (4, 2)), linewidth=1.1)
        axes.set_ylim(0.0, 1.0)
    elif len(values):
        low, high = np.quantile(values, [0.02, 0.98])
        shown = values[(values >= low) & (values <= high)]
        axes.hist(shown, bins=min(24, max(5, len(values) // 8)), color=colour, alpha=0.75)
        axes.axvline(float(shown.mean()), color=drawing.INK, linestyle=(0, (4, 2)), linewidth=1.1)
    axes.axvline(truth, color="#c25b4e", linewidth=1.6)
    axes.set_title(f"{'F_o, N' if force else 'b'}  {_short(name)}", fontsize=7.3)
    axes.set_yticks([])
    axes.grid(axis="y", visible=False)
    axes.spines["left"].set_visible(False)
    axes.locator_params(axis="x", nbins=3)
    axes.ticklabel_format(axis="x", useOffset=False)


def _short(parameter: str) -> str:
    return words.muscle(parameter).replace("medial pterygoid", "m. pteryg.")


def physician_view(table: pd.DataFrame) -> Figure:
    """Mean and sd of F_o and of b of every muscle, and both together as an ellipse."""
    muscles = list(dict.fromkeys(words.muscle(name) for name in table["parameter"]))
    values = {
        symbol: np.column_stack([_of(table, symbol, muscle) for muscle in muscles]) for symbol in ("log_F_o", "log_b")
    }
    truth = {
        symbol: [
            float(table.loc[table["parameter"] == f"{symbol}/{muscle.replace(' ', '_')}", "true_value"].iloc[0])
            for muscle in muscles
        ]
        for symbol in values
    }
    with drawing.style():
        figure = Figure(figsize=(10.2, 3.4), layout="constrained")
        force, exponent, both = figure.subplots(1, 3, width_ratios=(1.1, 0.8, 1.1))
        for axes, symbol, title in ((force, "log_F_o", "F_o, N"), (exponent, "log_b", "b")):
            drawn = values[symbol]
            for i, muscle in enumerate(muscles):
                colour = _SIDES[muscle.rsplit(" ", 1)[-1]]
                axes.errorbar(
                    drawn[:, i].mean(),
                    i,
                    xerr=drawn[:, i].std(),
                    fmt="o",
                    color=colour,
                    capsize=3,
                    markersize=5,
                )
                axes.plot(truth[symbol][i], i, marker="|", markersize=14, color="#c25b4e", markeredgewidth=2)
            axes.set(title=title, yticks=range(len(muscles)), ylim=(len(muscles) - 0.5, -0.5), xlim=(0, None))
            axes.set_yticklabels(muscles if axes is force else [])
            axes.grid(axis="y", visible=False)
        for i, muscle in enumerate(muscles):
            _ellipse(both, values["log_F_o"][:, i], values["log_b"][:, i], _SIDES[muscle.rsplit(" ", 1)[-1]])
            both.plot(truth["log_F_o"][i], truth["log_b"][i], marker="+", color="#c25b4e", markersize=8)
        both.set(title="Both, 95 % of the draws", xlabel="F_o, N", ylabel="b")
        return figure


def _of(table: pd.DataFrame, symbol: str, muscle: str) -> np.ndarray:
    name = f"{symbol}/{muscle.replace(' ', '_')}"
    return table.loc[table["parameter"] == name].sort_values("draw")["value"].to_numpy()


def _ellipse(axes: Axes, x: np.ndarray, y: np.ndarray, colour: str) -> None:
    """95 % of a normal distribution with the draws' mean and covariance."""
    if len(x) < 3:
        axes.plot(x, y, "o", color=colour, markersize=4)
        return
    size, turn = np.linalg.eigh(np.cov(x, y))
    width, height = 2.0 * np.sqrt(5.99 * np.maximum(size, 0.0))
    angle = float(np.degrees(np.arctan2(turn[1, 0], turn[0, 0])))
    axes.add_patch(Ellipse((x.mean(), y.mean()), width, height, angle=angle, facecolor=colour, alpha=0.35))
    axes.plot(x.mean(), y.mean(), "o", color=colour, markersize=3)
