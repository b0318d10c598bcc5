"""Pairs of parameters that a recording confuses: the belief's ellipse of each, the most correlated first."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from eval.patient.treatments import Treatment
from eval.report import drawing, template
from jawenv.anatomy import PARAMETER_NAMES

Array = NDArray[np.float64]

_CONFUSED, _MOST = 0.7, 4  # correlation from which a pair is shown, and how many are
_REACH = 2.4477  # sds of a plane's 95 % ellipse
_SIZE = (2.6, 2.4)  # inches
_LETTERS = 9.0  # points
_BAND, _LINE, _TRUTH = "#9dbfe2", "#23272e", "#a3123f"
_CSS = {_BAND: "var(--band)", _LINE: "var(--estimate)", _TRUTH: "var(--both)"}


def confused(last: Treatment, with_truth: bool) -> list[Markup]:
    """The most confused pairs, a picture each; none where no correlation is above 0.7.

    Args:
        last: its last belief is drawn.
        with_truth: whether the true values are.
    """
    cov = last.cov[-1]
    sd = np.sqrt(np.diagonal(cov))
    correlation = cov / np.outer(sd, sd)
    pairs = sorted(combinations(range(len(cov)), 2), key=lambda pair: -abs(correlation[pair]))[:_MOST]
    return [_picture(pair, last, with_truth) for pair in pairs if abs(correlation[pair]) > _CONFUSED]


def _picture(pair: tuple[int, int], last: Treatment, with_truth: bool) -> Markup:
    chosen, names = list(pair), [_in_words(parameter) for parameter in pair]
    mean, cov = last.mean[-1, chosen], last.cov[-1][np.ix_(chosen, chosen)]
    correlation = f"correlation {cov[0, 1] / np.sqrt(cov[0, 0] * cov[1, 1]):.2f}".replace("-", "−")
    with drawing.style():
        figure = Figure(figsize=_SIZE, layout="constrained")
        axes = figure.subplots()
        _draw(axes, mean, cov)
        if with_truth:
            axes.plot(*np.exp(last.truth[chosen]), "o", ms=4.0, color=_TRUTH)
        axes.set_xlabel(names[0], fontsize=_LETTERS)
        axes.set_ylabel(names[1], fontsize=_LETTERS)
        axes.set_title(correlation, fontsize=_LETTERS)
    return template.picture(figure, f"pair-{pair[0]}-{pair[1]}", f"{names[0]} and {names[1]}: {correlation}", _CSS)


def _draw(axes: Any, mean: Array, cov: Array) -> None:
    """The ellipse in the parameters' own units, on logarithmic axes."""
    turn = np.linspace(0.0, 2.0 * np.pi, 120)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    x, y = np.exp(mean[:, None] + _REACH * np.linalg.cholesky(cov) @ circle)
    axes.fill(x, y, color=_BAND, alpha=0.75, lw=0)
    axes.plot(*np.exp(mean), "+", ms=7.0, color=_LINE)
    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(3))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.3g}"))
        axis.set_minor_locator(MaxNLocator(1))
        axis.set_minor_formatter(FuncFormatter(lambda value, _: ""))


def _in_words(parameter: int) -> str:
    symbol, muscle = PARAMETER_NAMES[parameter].removeprefix("log_").split("/")
    return f"{muscle.replace('_', ' ')} {'Fₒ, N' if symbol == 'F_o' else symbol}"
