"""Pictures of two episodes in step: the jaw from two sides, and a bar for each parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import palette
from jawenv.rendering.film import KNOWN_SD, draw_backgrounds, draw_views, film_canvas, known_in_words
from jawenv.rendering.muscles import draw_colour_legend, split_name, symbol
from jawenv.rendering.palette import ACCENT, FAINT_INK, GRID, INK, SOFT_INK, TRACK
from jawenv.rendering.posterior import SD_LINES, SdScale, draw_sd
from jawenv.rendering.scene import Scene

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Box, Canvas

_FOOTER_Y = 696.0
_NAMES = 128.0  # room of the muscles' names


class PairRenderer:
    """Draws two scenes beside each other, off-screen: the jaw from two sides, and a bar for each parameter."""

    def __init__(self) -> None:
        self._canvas = film_canvas((1280, 720), (1280, 720))
        self._canvas.keep_as_background()

    def draw(self, left: Scene, right: Scene) -> NDArray[np.uint8]:
        """A new array (height, width, 3); the scenes' titles stand above their halves."""
        self._canvas.restore()
        for half, scene in enumerate((left, right)):
            _draw_half(self._canvas, 640.0 * half, scene)
        _draw_footer(self._canvas, max(left, right, key=lambda scene: scene.time_s))
        return self._canvas.pixels()


def _draw_half(canvas: Canvas, shift: float, scene: Scene) -> None:
    """Draw a scene in the half that begins ``shift`` design units from the left."""
    cards = [(10 + shift, 58.0, 306.0, 360.0), (324 + shift, 58.0, 306.0, 360.0), (10 + shift, 426.0, 620.0, 244.0)]
    for card in cards:
        canvas.rect(card, palette.CARD, radius=10, border=palette.BORDER)
    caption = known_in_words(scene)
    ink = palette.mix(palette.knowledge(float(scene.belief_sd.max())), INK, 0.45)
    used = canvas.text(caption, (shift + 626, 32), 19, ink, bold=True, anchor="right")
    canvas.text(scene.title, (shift + 16, 32), 22, INK, bold=True, fit=590 - used)
    for card, words in zip(cards, ("from the right", "from the front"), strict=False):
        canvas.text(words, (card[0] + 14, card[1] + 18), 11.5, SOFT_INK)
    side, front = ((x + 2, y + 32, width - 4, height - 40) for x, y, width, height in cards[:2])
    draw_backgrounds(canvas, side, front, scene)
    draw_views(canvas, side, front, scene)
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
