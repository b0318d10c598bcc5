"""Where the columns and rows of the panel of posteriors stand, for any number of muscles."""

from __future__ import annotations

import math
from dataclasses import dataclass

from jawenv.rendering.canvas import Box
from jawenv.rendering.muscles import split_name
from jawenv.rendering.scene import Scene

SHOWN_SD = 3.0  # prior standard deviations to either side
BEST_SD = 0.01
_HEADED_BLOCKS = 3  # with more kinds of muscles, their names stand beside the rows instead of above them
_ROW = 46.0
_HEADER = 20.0


@dataclass(frozen=True)
class SdScale:
    """Where the bars of standard deviations begin, and how long the longest is."""

    left: float
    width: float

    def x(self, sd: float, worst: float) -> float:
        """Place of a standard deviation on a log scale from the worst prior to the best known."""
        share = math.log(worst / sd) / math.log(worst / BEST_SD)
        return self.left + min(max(share, 0.0), 1.0) * self.width


@dataclass(frozen=True)
class Columns:
    """Left edges and widths of the panel's columns; top and bottom of its rows.

    `number_width` is the room beside a value's bar for its number, 0 where that stands below the bar.
    """

    value_left: tuple[float, float]
    value_width: float
    number_width: float
    sd: SdScale
    top: float
    bottom: float

    def value_x(self, column: int, prior_sds: float) -> float:
        """Place of a value in prior standard deviations from the prior mean; the scale's ends hold it."""
        share = 0.5 + min(max(prior_sds, -SHOWN_SD), SHOWN_SD) / (2 * SHOWN_SD)
        return self.value_left[column] + share * self.value_width


@dataclass(frozen=True)
class Row:
    """One muscle: its name, the letter of its side, the middle and the height of its row."""

    muscle: str
    letter: str
    middle: float
    height: float
    number_below: bool

    @property
    def bar(self) -> float:
        """Height of the bars of its values."""
        return self.middle - (5 if self.number_below else 0)

    @property
    def sd(self) -> tuple[float, float]:
        """Heights of the bars of its two standard deviations."""
        return (self.middle - 11, self.middle + 6) if self.number_below else (self.middle - 6, self.middle + 6)


@dataclass(frozen=True)
class Block:
    """One kind of muscle: its name, the place of the name, and one row or two."""

    kind: str
    top: float
    height: float
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Layout:
    """The whole panel; `joint` is the room below the rows, if there is enough for pictures of pairs."""

    columns: Columns
    blocks: tuple[Block, ...]
    headed: bool
    joint: Box | None


def lay_out(box: Box, scene: Scene) -> Layout:
    """Give every muscle its row."""
    kinds: dict[str, list[str]] = {}
    for muscle in scene.muscles:
        kinds.setdefault(split_name(muscle)[0], []).append(muscle)
    headed = len(kinds) <= _HEADED_BLOCKS
    columns = _columns(box, headed)
    most = max(len(muscles) for muscles in kinds.values())
    header = _HEADER if headed else 0.0
    height = min((columns.bottom - columns.top) / len(kinds), header + most * _ROW)
    row = (height - header) / most
    blocks = []
    for number, (kind, muscles) in enumerate(kinds.items()):
        top = columns.top + number * height
        rows = [
            Row(muscle, split_name(muscle)[1][:1].upper(), top + header + (line + 0.5) * row, row, headed)
            for line, muscle in enumerate(muscles)
        ]
        blocks.append(Block(kind, top, height, tuple(rows)))
    end = columns.top + len(kinds) * height
    x, _, width, _ = box
    joint = (x + 16, end + 6, width - 32, columns.bottom - end - 2) if columns.bottom - end > 110 else None
    return Layout(columns, tuple(blocks), headed, joint)


def _columns(box: Box, headed: bool) -> Columns:
    x, y, width, height = box
    left, right = x + 16, x + width - 16
    value, beside, gap, tag, number = (100.0, 0.0, 14.0, 20.0, 42.0) if headed else (62.0, 36.0, 12.0, 16.0, 40.0)
    first = left + (22 if headed else 92)
    second = first + value + beside + gap
    sd_left = second + value + beside + gap + tag
    sd_width = right - number - sd_left
    return Columns((first, second), value, beside, SdScale(sd_left, sd_width), y + 74, y + height - 40)
