"""The panel of posteriors: what is believed about every parameter, and how well it is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

from jawenv.envs.rendering import palette
from jawenv.envs.rendering.canvas import Box, Canvas
from jawenv.envs.rendering.muscles import kind_of, symbol
from jawenv.envs.rendering.palette import FAINT_INK, GRID, INK, SOFT_INK, TRACK
from jawenv.envs.rendering.scene import Scene

_SHOWN_SD = 3.0  # prior standard deviations to either side
_BEST_SD = 0.01
_SD_LINES = (0.10, 0.05, 0.02)
_PARAMETERS = ("log_F_o", "log_b")


@dataclass(frozen=True)
class _Columns:
    """Left edges and widths of the panel's columns; top and bottom of its rows."""

    value_left: tuple[float, float]
    value_width: float
    sd_left: float
    sd_width: float
    top: float
    bottom: float

    def value_x(self, column: int, prior_sds: float) -> float:
        """Place of a value in prior standard deviations from the prior mean; the scale's ends hold it."""
        share = 0.5 + min(max(prior_sds, -_SHOWN_SD), _SHOWN_SD) / (2 * _SHOWN_SD)
        return self.value_left[column] + share * self.value_width

    def sd_x(self, sd: float, worst: float) -> float:
        """Place of a standard deviation on a log scale from the worst prior to the best known."""
        share = math.log(worst / sd) / math.log(worst / _BEST_SD)
        return self.sd_left + min(max(share, 0.0), 1.0) * self.sd_width


def _columns(box: Box) -> _Columns:
    x, y, width, height = box
    left, right = x + 16, x + width - 16
    value, gap, tag, number = 100.0, 14.0, 20.0, 42.0
    first = left + 22
    second = first + value + gap
    sd_left = second + value + gap + tag
    return _Columns((first, second), value, sd_left, right - number - sd_left, y + 74, y + height - 40)


def draw_posterior_background(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Draw headings, scales and legend."""
    columns = _columns(box)
    worst = float(scene.prior_sd.max())
    heading = box[1] + 50
    for column, (name, what) in enumerate((("log_F_o", "force at rest"), ("log_b", "stiffness"))):
        left = columns.value_left[column]
        used = symbol(canvas, name, (left, heading), 12.5, INK)
        canvas.text(what, (left + used + 6, heading), 10.5, SOFT_INK, fit=columns.value_width - used - 4)
    canvas.text("sd, %", (columns.sd_left - 20, heading), 12, INK, bold=True)
    for sd in _SD_LINES:
        x = columns.sd_x(sd, worst)
        canvas.line([(x, columns.top - 12), (x, columns.bottom)], palette.mix(GRID, FAINT_INK, 0.22), 0.8)
        canvas.text(f"{100 * sd:.0f}", (x, heading), 10.5, SOFT_INK, anchor="centre")
    _draw_legend(canvas, box, scene)


def _draw_legend(canvas: Canvas, box: Box, scene: Scene) -> None:
    x, y = box[0] + 38, box[1] + box[3] - 20
    canvas.rect((x, y - 5, 34, 10), TRACK, radius=3)
    x += 40 + canvas.text("prior ± 2 sd", (x + 40, y), 10.5, SOFT_INK) + 18
    canvas.rect((x, y - 4, 22, 8), palette.knowledge(0.05), radius=4)
    x += 28 + canvas.text("posterior ± 2 sd", (x + 28, y), 10.5, SOFT_INK) + 18
    if scene.truth is not None:
        _draw_truth(canvas, x + 4, y + 8)
        canvas.text("truth, unseen by the filter", (x + 14, y), 10.5, SOFT_INK, fit=box[0] + box[2] - x - 26)


def draw_posterior(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Draw one row per muscle, left and right side together."""
    columns = _columns(box)
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    kinds = list(dict.fromkeys(kind_of(name) for name in scene.muscle_names))
    block = (columns.bottom - columns.top) / len(kinds)
    row = min(46.0, (block - 20) / 2)
    for number, kind in enumerate(kinds):
        top = columns.top + number * block
        canvas.text(kind.replace("_", " ").capitalize(), (box[0] + 16, top + 8), 12, INK, bold=True)
        for line, side in enumerate(("left", "right")):
            muscle = f"{kind}_{side}"
            if muscle in scene.muscle_names:
                middle = top + 20 + (line + 0.5) * row
                _draw_row(canvas, columns, scene, index, muscle, middle)


def _draw_row(
    canvas: Canvas, columns: _Columns, scene: Scene, index: dict[str, int], muscle: str, middle: float
) -> None:
    side = "L" if muscle.endswith("_left") else "R"
    canvas.text(side, (columns.value_left[0] - 15, middle - 5), 11, SOFT_INK, bold=True, anchor="centre")
    for column, parameter in enumerate(_PARAMETERS):
        i = index[f"{parameter}/{muscle}"]
        _draw_value(canvas, columns, scene, i, column, middle)
        _draw_sd(canvas, columns, scene, i, parameter, middle + (-11 if column == 0 else 6))


def _draw_value(canvas: Canvas, columns: _Columns, scene: Scene, i: int, column: int, middle: float) -> None:
    """Interval of the posterior over the prior's, and the median with its unit."""
    y = middle - 5
    prior_mean, prior_sd = scene.prior_mean[i], scene.prior_sd[i]

    def place(value: float) -> float:
        return columns.value_x(column, (value - prior_mean) / prior_sd)

    left, right = columns.value_left[column], columns.value_left[column] + columns.value_width
    canvas.line([(left, y), (right, y)], GRID, 1.0)
    prior_left, prior_right = columns.value_x(column, -2), columns.value_x(column, 2)
    canvas.rect((prior_left, y - 6, prior_right - prior_left, 12), TRACK, radius=3)
    mean, sd = float(scene.belief_mean[i]), float(scene.belief_sd[i])
    low, high = place(mean - 2 * sd), place(mean + 2 * sd)
    width = max(high - low, 6.0)
    start = min(max((low + high - width) / 2, left), right - width)
    canvas.rect((start, y - 4.5, width, 9), palette.knowledge(sd), radius=min(4.5, width / 2))
    if width > 9:
        canvas.line([(place(mean), y - 4), (place(mean), y + 4)], palette.CARD, 1.4)
    if scene.truth is not None:
        _draw_truth(canvas, place(float(scene.truth[i])), y)
    words = f"{math.exp(mean):#.3g}".rstrip(".") + (" N" if column == 0 else "")
    canvas.text(words, (left, middle + 11), 11, SOFT_INK)


def _draw_truth(canvas: Canvas, x: float, y: float) -> None:
    canvas.polygon([(x - 4.2, y - 13.5), (x + 4.2, y - 13.5), (x, y - 6.5)], INK)
    canvas.line([(x, y - 7), (x, y - 4.5)], INK, 1.2)


def _draw_sd(canvas: Canvas, columns: _Columns, scene: Scene, i: int, parameter: str, y: float) -> None:
    """Bar that grows to the right as the standard deviation shrinks."""
    worst = float(scene.prior_sd.max())
    sd = float(scene.belief_sd[i])
    symbol(canvas, parameter, (columns.sd_left - 18, y), 10, SOFT_INK)
    canvas.rect((columns.sd_left, y - 3.5, columns.sd_width, 7), TRACK, radius=3.5)
    end = columns.sd_x(sd, worst)
    length = max(end - columns.sd_left, 4.0)
    canvas.rect((columns.sd_left, y - 3.5, length, 7), palette.knowledge(sd), radius=3.5)
    for line in _SD_LINES:
        x = columns.sd_x(line, worst)
        canvas.line([(x, y - 3.5), (x, y + 3.5)], palette.CARD, 1.0)
    right = columns.sd_left + columns.sd_width + 38
    words = f"{100 * sd:.1f} %" if sd < 0.0995 else f"{100 * sd:.0f} %"
    canvas.text(words, (right, y), 10.5, INK, anchor="right")
