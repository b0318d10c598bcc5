"""The panel of posteriors: what is believed about every parameter, how well it is known, and where each row stands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from jawenv.rendering import palette
from jawenv.rendering.muscles import split_name, symbol
from jawenv.rendering.palette import FAINT_INK, GRID, INK, SOFT_INK, TRACK
from jawenv.rendering.scene import Scene

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Box, Canvas

SHOWN_SD = 3.0  # prior standard deviations to either side
BEST_SD = 0.01
_ROW = 46.0
_NAMES, _VALUE, _NUMBER, _GAP, _TAG, _PERCENT = 92.0, 62.0, 36.0, 12.0, 16.0, 40.0
"""Widths: of names, of a value's bar and of its number, between columns, of a parameter's letter, of an sd's number."""
SD_LINES = (0.10, 0.05, 0.02)
_LABEL_ROOM = 16.0
_PARAMETERS = ("log_F_o", "log_b")


@dataclass(frozen=True)
class SdScale:
    """Scale of the bars of standard deviations: where they begin, and how long the longest is."""

    left: float
    width: float

    def x(self, sd: float, worst: float) -> float:
        """Place of a standard deviation on a log scale from the worst prior to the best known."""
        share = math.log(worst / sd) / math.log(worst / BEST_SD)
        return self.left + min(max(share, 0.0), 1.0) * self.width


@dataclass(frozen=True)
class Columns:
    """Left edges and widths of the panel's columns; top and bottom of its rows."""

    value_left: tuple[float, float]
    sd: SdScale
    top: float
    bottom: float

    def value_x(self, column: int, prior_sds: float) -> float:
        """Place of a value in prior standard deviations from the prior mean; the scale's ends hold it."""
        share = 0.5 + min(max(prior_sds, -SHOWN_SD), SHOWN_SD) / (2 * SHOWN_SD)
        return self.value_left[column] + share * _VALUE


@dataclass(frozen=True)
class _MuscleRow:
    """One muscle: its name, the letter of its side, the middle and the height of its row."""

    muscle: str
    letter: str
    middle: float
    height: float


@dataclass(frozen=True)
class Block:
    """One kind of muscle: its name, the place of the name, and one row or two."""

    kind: str
    top: float
    height: float
    rows: tuple[_MuscleRow, ...]


@dataclass(frozen=True)
class _Layout:
    """The whole panel."""

    columns: Columns
    blocks: tuple[Block, ...]


def lay_out(box: Box, scene: Scene) -> _Layout:
    """Give every muscle its row."""
    kinds: dict[str, list[str]] = {}
    for muscle in scene.muscles:
        kinds.setdefault(split_name(muscle)[0], []).append(muscle)
    x, y, width, height = box
    first = x + 16 + _NAMES
    second = first + _VALUE + _NUMBER + _GAP
    sd_left = second + _VALUE + _NUMBER + _GAP + _TAG
    columns = Columns((first, second), SdScale(sd_left, x + width - 16 - _PERCENT - sd_left), y + 74, y + height - 40)
    most = max(len(muscles) for muscles in kinds.values())
    row = min((columns.bottom - columns.top) / len(kinds) / most, _ROW)
    blocks = []
    for number, (kind, muscles) in enumerate(kinds.items()):
        top = columns.top + number * most * row
        rows = [
            _MuscleRow(muscle, split_name(muscle)[1][:1].upper(), top + (line + 0.5) * row, row)
            for line, muscle in enumerate(muscles)
        ]
        blocks.append(Block(kind, top, most * row, tuple(rows)))
    return _Layout(columns, tuple(blocks))


def draw_posterior_background(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Draw headings, scales and legend."""
    layout = lay_out(box, scene)
    columns, worst = layout.columns, float(scene.prior_sd.max())
    heading, end = box[1] + 50, layout.blocks[-1].top + layout.blocks[-1].height
    for column, (name, quantity) in enumerate(zip(_PARAMETERS, ("closed, N", "exponent"), strict=True)):
        left = columns.value_left[column]
        used = symbol(canvas, name, (left, heading), 12.5, INK)
        room = _VALUE + _NUMBER - used - 4
        canvas.text(quantity, (left + used + 6, heading), 10.5, SOFT_INK, fit=room)
    canvas.text("sd", (columns.sd.left - _TAG, heading), 12, INK, bold=True)
    labelled = -math.inf
    for sd in SD_LINES:
        x = columns.sd.x(sd, worst)
        canvas.line([(x, columns.top - 12), (x, end)], palette.mix(GRID, FAINT_INK, 0.22), 0.8)
        if x - labelled > _LABEL_ROOM:
            canvas.text(f"{100 * sd:.0f}", (x, heading), 10.5, SOFT_INK, anchor="centre")
            labelled = x
    for block in layout.blocks:
        _draw_block_names(canvas, box, layout, block)
    _draw_legend(canvas, box, scene)


def _draw_block_names(canvas: Canvas, box: Box, layout: _Layout, block: Block) -> None:
    """Name a kind of muscle, and the sides of its rows, beside them."""
    lines = (block.kind.replace("_", " ").capitalize() or "All closing muscles").split(" ")
    for number, word in enumerate(lines):
        y = block.top + block.height / 2 + 13 * (number - (len(lines) - 1) / 2)
        canvas.text(word, (box[0] + 16, y), 11, INK, bold=True, fit=72)
    for row in block.rows:
        place = (layout.columns.value_left[0] - 10, row.middle)
        canvas.text(row.letter, place, 11, SOFT_INK, bold=True, anchor="centre")


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
    """Draw one row per muscle."""
    layout = lay_out(box, scene)
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    for block in layout.blocks:
        for row in block.rows:
            _draw_row(canvas, layout.columns, scene, index, row)


def _draw_row(canvas: Canvas, columns: Columns, scene: Scene, index: dict[str, int], row: _MuscleRow) -> None:
    for column, parameter in enumerate(_PARAMETERS):
        i = index[f"{parameter}/{row.muscle}"]
        _draw_value(canvas, columns, scene, i, column, row)
        y = row.middle + (1 if column else -1) * min(9.0, 0.25 * row.height)
        symbol(canvas, parameter, (columns.sd.left - 18, y), 10, SOFT_INK)
        draw_sd(canvas, columns.sd, float(scene.belief_sd[i]), float(scene.prior_sd.max()), y)


def _draw_value(canvas: Canvas, columns: Columns, scene: Scene, i: int, column: int, row: _MuscleRow) -> None:
    """Interval of the posterior over the prior's, and the median with its unit."""
    y = row.middle
    half = min(4.5, 0.125 * row.height)
    prior_mean, prior_sd = scene.prior_mean[i], scene.prior_sd[i]

    def place(value: float) -> float:
        return columns.value_x(column, (value - prior_mean) / prior_sd)

    left, right = columns.value_left[column], columns.value_left[column] + _VALUE
    canvas.line([(left, y), (right, y)], GRID, 1.0)
    prior_left, prior_right = columns.value_x(column, -2), columns.value_x(column, 2)
    canvas.rect((prior_left, y - half - 1.5, prior_right - prior_left, 2 * half + 3), TRACK, radius=3)
    mean, sd = float(scene.belief_mean[i]), float(scene.belief_sd[i])
    low, high = place(mean - 2 * sd), place(mean + 2 * sd)
    width = max(high - low, 6.0)
    start = min(max((low + high - width) / 2, left), right - width)
    canvas.rect((start, y - half, width, 2 * half), palette.knowledge(sd), radius=min(half, width / 2))
    if width > 9:
        canvas.line([(place(mean), y - half + 0.5), (place(mean), y + half - 0.5)], palette.CARD, 1.4)
    if scene.truth is not None:
        _draw_truth(canvas, place(float(scene.truth[i])), y + 4.5 - half)
    words = f"{math.exp(mean):#.3g}".rstrip(".")
    canvas.text(words, (right + _NUMBER, y), 10.5, SOFT_INK, anchor="right")


def _draw_truth(canvas: Canvas, x: float, y: float) -> None:
    canvas.polygon([(x - 4.2, y - 13.5), (x + 4.2, y - 13.5), (x, y - 6.5)], INK)
    canvas.line([(x, y - 7), (x, y - 4.5)], INK, 1.2)


def draw_sd(canvas: Canvas, scale: SdScale, sd: float, worst: float, y: float, bold: bool = False) -> None:
    """Bar of one standard deviation, which grows to the right as it shrinks; ``worst`` leaves it empty."""
    canvas.rect((scale.left, y - 3.5, scale.width, 7), TRACK, radius=3.5)
    length = max(scale.x(sd, worst) - scale.left, 4.0)
    canvas.rect((scale.left, y - 3.5, length, 7), palette.knowledge(sd), radius=3.5)
    for line in SD_LINES:
        x = scale.x(line, worst)
        canvas.line([(x, y - 3.5), (x, y + 3.5)], palette.CARD, 1.0)
    words = f"{100 * sd:.1f} %" if sd < 0.0995 else f"{100 * sd:.0f} %"
    canvas.text(words, (scale.left + scale.width + 38, y), 10.5, INK, bold=bold, anchor="right")
