"""One number of a muscle over time: the 95 % interval as a band around the estimate, and where normal ends."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from eval.patient.treatments import Treatment

Array = NDArray[np.float64]

WIDTH, HEIGHT = 240.0, 96.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 24.0, 236.0, 5.0, 80.0
SD_95 = 1.959964
_POINTS = 160  # of a curve, at most


@dataclass(frozen=True)
class Axis:
    """Logarithmic vertical axis, the same for all muscles.

    Attributes:
        low: lower end, in the quantity's own unit.
        high: upper end.
        ticks: where numbers stand.
        threshold: where normal ends.
    """

    low: float
    high: float
    ticks: tuple[float, ...]
    threshold: float

    def y(self, log_value: Array) -> Array:
        """Height in the picture of natural logs; what lies outside stands at the edge."""
        share = (log_value - math.log(self.low)) / (math.log(self.high) - math.log(self.low))
        return _BOTTOM - np.clip(share, 0.0, 1.0) * (_BOTTOM - _TOP)


def moments(course: Sequence[Treatment]) -> Array:
    """(T,) of all kept times of a course: seconds of a single treatment, or treatments since the start."""
    if len(course) == 1:
        return course[0].time
    return np.concatenate([number + each.time / each.time[-1] for number, each in enumerate(course)])


def chart(course: Sequence[Treatment], parameter: int, axis: Axis, label: str, with_truth: bool) -> Markup:
    """The estimate of a parameter over a course.

    Args:
        course: of at least one treatment.
        parameter: its number.
        axis: the vertical one.
        label: what a screen reader says.
        with_truth: whether the true value is drawn.
    """
    time = moments(course)
    mean = np.concatenate([each.mean[:, parameter] for each in course])
    sd = np.sqrt(np.concatenate([each.cov[:, parameter, parameter] for each in course]))
    chosen = np.unique(np.linspace(0, len(time) - 1, _POINTS).round().astype(int))
    x = _LEFT + (_RIGHT - _LEFT) * time[chosen] / time[-1]
    low, middle, high = (axis.y((mean + factor * sd)[chosen]) for factor in (-SD_95, 0.0, SD_95))
    normal = float(axis.y(np.array(math.log(axis.threshold))))
    parts = [
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" class="chart" role="img" aria-label="{html.escape(label)}" '
        'xmlns="http://www.w3.org/2000/svg">',
        f'<rect class="normal-range" x="{_LEFT:g}" y="{normal:.1f}" width="{_RIGHT - _LEFT:g}" '
        f'height="{_BOTTOM - normal:.1f}"/>',
        *(_tick(axis, value) for value in axis.ticks),
        f'<path class="band" d="M{_points(x, high)}L{_points(x[::-1], low[::-1])}Z"/>',
        f'<text class="range" x="{_RIGHT - 3:g}" y="{_BOTTOM - 4:g}" text-anchor="end">normal</text>',
        f'<path class="limit" d="M{_LEFT:g} {normal:.1f}H{_RIGHT:g}"/>',
        f'<path class="estimate" d="M{_points(x, middle)}"/>',
    ]
    if with_truth:
        truth = np.concatenate([np.full(len(each.time), each.truth[parameter]) for each in course])
        parts.append(f'<path class="truth" d="M{_points(x, axis.y(truth[chosen]))}"/>')
    begins, ends = ("0 s", f"{time[-1]:g} s") if len(course) == 1 else ("start", f"{len(course)} treatments")
    foot = _BOTTOM + 12.0
    parts += [
        f'<text x="{_LEFT:g}" y="{foot:g}">{begins}</text>',
        f'<text x="{_RIGHT:g}" y="{foot:g}" text-anchor="end">{ends}</text></svg>',
    ]
    return Markup("".join(parts))  # noqa: S704  (numbers, our own words, and an escaped label)


def _tick(axis: Axis, value: float) -> str:
    y = float(axis.y(np.array(math.log(value))))
    return (
        f'<path class="grid" d="M{_LEFT:g} {y:.1f}H{_RIGHT:g}"/>'
        f'<text x="{_LEFT - 4:g}" y="{y + 3:.1f}" text-anchor="end">{value:g}</text>'
    )


def _points(x: Array, y: Array) -> str:
    return "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y, strict=True))
