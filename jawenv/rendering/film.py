"""Pictures of films: the jaw from two sides with what is known so far, alone, or of two episodes in step."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jawenv.base.extras import needs
from jawenv.rendering import palette
from jawenv.rendering.camera import front_camera, side_camera
from jawenv.rendering.muscles import draw_colour_legend, split_name, symbol
from jawenv.rendering.palette import ACCENT, FAINT_INK, GRID, INK, SOFT_INK, TRACK
from jawenv.rendering.scene import Scene

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Box, Canvas

KNOWN_SD = 0.05
"""Largest sd of a known parameter: the ranking's target."""
JAW_SIZE = (640, 402)
"""Width and height of a film of the jaw alone, design units."""
_FOOTER_Y = 696.0
_NAMES = 128.0  # room of the muscles' names


class JawRenderer:
    """Draws the jaw from the right and from the front, off-screen, and above it what is known so far.

    Args:
        width: of the pictures in pixels; `height` follows from it.
    """

    def __init__(self, width: int = JAW_SIZE[0]) -> None:
        self.height = 2 * round(width * JAW_SIZE[1] / JAW_SIZE[0] / 2)
        self._canvas = _canvas((width, self.height), JAW_SIZE)
        self._begun = False

    def draw(self, scene: Scene) -> NDArray[np.uint8]:
        """A new array (height, width, 3); all scenes must be of one model."""
        side, front = (0.0, 58.0, 320.0, 340.0), (320.0, 58.0, 320.0, 340.0)
        if not self._begun:
            self._canvas.rect((0, 0, *JAW_SIZE), palette.CARD)
            _draw_backgrounds(self._canvas, side, front, scene)
            self._canvas.keep_as_background()
            self._begun = True
        self._canvas.restore()
        _draw_views(self._canvas, side, front, scene)
        words = f"{_known(scene)}, the worst within {100 * scene.belief_sd.max():.1f} %"
        self._canvas.text(f"{scene.time_s:.1f} s", (14, 20), 20, SOFT_INK)
        self._canvas.text(words, (626, 20), 20, INK, bold=True, anchor="right", fit=530)
        return self._canvas.pixels()


class PairRenderer:
    """Draws two scenes beside each other, off-screen: the jaw from two sides, and a bar for each parameter."""

    def __init__(self) -> None:
        self._canvas = _canvas((1280, 720), (1280, 720))
        self._canvas.keep_as_background()

    def draw(self, left: Scene, right: Scene) -> NDArray[np.uint8]:
        """A new array (height, width, 3); the scenes' titles stand above their halves."""
        self._canvas.restore()
        for half, scene in enumerate((left, right)):
            _draw_half(self._canvas, 640.0 * half, scene)
        _draw_footer(self._canvas, max(left, right, key=lambda scene: scene.time_s))
        return self._canvas.pixels()


def _canvas(size: tuple[int, int], design: tuple[int, int]) -> Canvas:
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    with needs("a film", "pygame", "render"):
        from jawenv.rendering.canvas import Canvas
    return Canvas(size, design)


def _known(scene: Scene) -> str:
    return f"{int((scene.belief_sd <= KNOWN_SD).sum())} of {len(scene.belief_sd)} within {100 * KNOWN_SD:g} %"


def _draw_backgrounds(canvas: Canvas, side: Box, front: Box, scene: Scene) -> None:
    from jawenv.rendering.views import draw_front_background, draw_side_background

    draw_side_background(canvas, side_camera(side, scene.planar), side)
    draw_front_background(canvas, front_camera(front), front)
    for letter, x in (("R", front[0] + 14), ("L", front[0] + front[2] - 14)):
        canvas.text(letter, (x, front[1] + 168), 13, FAINT_INK, bold=True, anchor="centre")


def _draw_views(canvas: Canvas, side: Box, front: Box, scene: Scene) -> None:
    from jawenv.rendering.views import draw_front, draw_side

    draw_side(canvas, side_camera(side, scene.planar), side, scene)
    draw_front(canvas, front_camera(front), front, scene)


def _draw_half(canvas: Canvas, shift: float, scene: Scene) -> None:
    """Draw a scene in the half that begins ``shift`` design units from the left."""
    cards = [(10 + shift, 58.0, 306.0, 360.0), (324 + shift, 58.0, 306.0, 360.0), (10 + shift, 426.0, 620.0, 244.0)]
    for card in cards:
        canvas.rect(card, palette.CARD, radius=10, border=palette.BORDER)
    caption = _known(scene)
    ink = palette.mix(palette.knowledge(float(scene.belief_sd.max())), INK, 0.45)
    used = canvas.text(caption, (shift + 626, 32), 19, ink, bold=True, anchor="right")
    canvas.text(scene.title, (shift + 16, 32), 22, INK, bold=True, fit=590 - used)
    for card, words in zip(cards, ("from the right", "from the front"), strict=False):
        canvas.text(words, (card[0] + 14, card[1] + 18), 11.5, SOFT_INK)
    side, front = ((x + 2, y + 32, width - 4, height - 40) for x, y, width, height in cards[:2])
    _draw_backgrounds(canvas, side, front, scene)
    _draw_views(canvas, side, front, scene)
    _draw_knowledge(canvas, cards[2], scene)


def _draw_footer(canvas: Canvas, scene: Scene) -> None:
    """Draw the legend of the colours, and the time."""
    draw_colour_legend(canvas, (18, _FOOTER_Y - 4), 400.0)
    left, right = 560.0, 1180.0
    share = min(max(scene.time_s / scene.episode_s, 0.0), 1.0)
    canvas.text("Time", (left - 52, _FOOTER_Y), 13, SOFT_INK)
    canvas.rect((left, _FOOTER_Y - 4, right - left, 8), palette.mix(TRACK, FAINT_INK, 0.25), radius=4)
    canvas.rect((left, _FOOTER_Y - 4, max(share * (right - left), 8), 8), ACCENT, radius=4)
    canvas.text(f"{scene.time_s:.1f} s", (1262, _FOOTER_Y), 17, INK, bold=True, anchor="right")


def _draw_knowledge(canvas: Canvas, card: Box, scene: Scene) -> None:
    """One row per muscle, with a bar for each of its two parameters."""
    from jawenv.rendering.posterior import SD_LINES, SdScale, draw_sd

    x, y, width, height = card
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    worst = float(scene.prior_sd.max())
    column = (width - _NAMES - 16) / 2
    scales = [SdScale(x + _NAMES + k * column + 24, column - 72) for k in (0, 1)]
    top, bottom = y + 34, y + height - 8
    row = (bottom - top) / len(scene.muscles)
    canvas.text("sd of", (x + 16, y + 18), 12, INK, bold=True)
    for parameter, scale in zip(("log_F_o", "log_b"), scales, strict=True):
        for sd in SD_LINES:
            tick = scale.x(sd, worst)
            canvas.line([(tick, top - 4), (tick, bottom)], palette.mix(GRID, FAINT_INK, 0.22), 0.8)
            canvas.text(f"{100 * sd:.0f} %", (tick, y + 18), 10.5, SOFT_INK, anchor="centre")
        symbol(canvas, parameter, (scale.left, y + 18), 12.5, INK)
        for number, muscle in enumerate(scene.muscles):
            sd = float(scene.belief_sd[index[f"{parameter}/{muscle}"]])
            draw_sd(canvas, scale, sd, worst, top + (number + 0.5) * row, bold=sd <= KNOWN_SD)
    for number, muscle in enumerate(scene.muscles):
        kind, side = split_name(muscle)
        words = f"{kind.replace('_', ' ').capitalize()} {side[:1].upper()}".strip() if kind else f"{side} side"
        canvas.text(words, (x + 16, top + (number + 0.5) * row), 11.5, INK, fit=_NAMES - 10)
