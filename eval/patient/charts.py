"""One number of a muscle over time: the 95 % interval as a band around the estimate, and where normal ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from eval.patient.treatments import Treatment
from eval.report import drawing, template

Array = NDArray[np.float64]

SIZE = (240.0, 96.0)  # of a chart, points
SD_95 = 1.959964
_LETTERS = 10.5  # points
_POINTS = 160  # of a curve, at most
_LEFT, _RIGHT, _TOP, _BOTTOM = 24.0, 4.0, 5.0, 16.0  # margins, points
_ESTIMATE, _BAND, _NORMAL, _NORMAL_RANGE, _TRUTH = "#23272e", "#9dbfe2", "#2b7a3f", "#e2f1e4", "#a3123f"
_CSS = {
    _ESTIMATE: "var(--estimate)",
    _BAND: "var(--band)",
    _NORMAL: "var(--normal)",
    _NORMAL_RANGE: "var(--normal-back)",
    _TRUTH: "var(--both)",
}


@dataclass(frozen=True)
class Axis:
    """Logarithmic vertical axis, the same for all muscles."""

    low: float  # lower end, in the quantity's own unit
    high: float  # upper end
    ticks: tuple[float, ...]  # where numbers stand
    threshold: float  # where normal ends


def moments(course: Sequence[Treatment]) -> Array:
    """(T,) of all kept times of a course: seconds of a single treatment, or treatments since the start."""
    if len(course) == 1:
        return course[0].time
    return np.concatenate([number + treatment.time / treatment.time[-1] for number, treatment in enumerate(course)])


def chart(course: Sequence[Treatment], parameter: int, axis: Axis, label: str, with_truth: bool) -> Markup:
    """The estimate of a parameter over a course.

    Args:
        course: of at least one treatment.
        parameter: its number.
        axis: the vertical one.
        label: text for a screen reader.
        with_truth: whether the true value is drawn.
    """
    time = moments(course)
    mean = np.concatenate([treatment.mean[:, parameter] for treatment in course])
    sd = np.sqrt(np.concatenate([treatment.cov[:, parameter, parameter] for treatment in course]))
    chosen = np.unique(np.linspace(0, len(time) - 1, _POINTS).round().astype(int))
    low, middle, high = (
        np.clip(np.exp(mean + factor * sd)[chosen], axis.low, axis.high) for factor in (-SD_95, 0.0, SD_95)
    )
    width, height = SIZE
    with drawing.style():
        figure = Figure(figsize=(width / 72, height / 72))
        box = (_LEFT / width, _BOTTOM / height, 1 - (_LEFT + _RIGHT) / width, 1 - (_TOP + _BOTTOM) / height)
        axes = figure.add_axes(box, xlim=(0.0, time[-1]), yscale="log", ylim=(axis.low, axis.high))
        axes.axhspan(axis.low, axis.threshold, color=_NORMAL_RANGE, lw=0, zorder=0)
        axes.fill_between(time[chosen], low, high, color=_BAND, alpha=0.75, lw=0)
        axes.axhline(axis.threshold, color=_NORMAL, lw=1.2, ls=(0, (4, 2.5)))
        axes.plot(time[chosen], middle, color=_ESTIMATE, lw=1.5)
        if with_truth:
            truth = np.concatenate(
                [np.full(len(treatment.time), np.exp(treatment.truth[parameter])) for treatment in course]
            )
            axes.plot(time[chosen], np.clip(truth[chosen], axis.low, axis.high), color=_TRUTH, lw=1.2, ls=(0, (1.5, 2)))
        style: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points", "size": _LETTERS}
        axes.annotate("normal", (1, 0), (-3, 4), ha="right", color=_NORMAL, **style)
        ends = ("0 s", f"{time[-1]:g} s") if len(course) == 1 else ("start", f"{len(course)} treatments")
        for end, text in enumerate(ends):
            axes.annotate(text, (end, 0), (0, -12), ha=("left", "right")[end], **style)
        axes.set_yticks(axis.ticks, [f"{tick:g}" for tick in axis.ticks])
        axes.yaxis.set_minor_locator(NullLocator())
        axes.tick_params(length=0, labelbottom=False, labelsize=_LETTERS)
        axes.grid(axis="x", visible=False)
        axes.spines[:].set_visible(False)
    return template.picture(figure, f"chart-{parameter}", label, _CSS)
