"""Pictures of films: the jaw from two sides with what is known so far."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jawenv.base.extras import needs
from jawenv.rendering import palette
from jawenv.rendering.camera import front_camera, side_camera
from jawenv.rendering.palette import FAINT_INK, INK, SOFT_INK
from jawenv.rendering.scene import Scene

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Box, Canvas

KNOWN_SD = 0.05
"""Largest sd of a known parameter: the ranking's target."""
JAW_SIZE = (640, 402)
"""Width and height of a film of the jaw alone, design units."""


class JawRenderer:
    """Draws the jaw from the right and from the front, off-screen, and above it what is known so far.

    Args:
        width: of the pictures in pixels; `height` follows from it.
    """

    def __init__(self, width: int = JAW_SIZE[0]) -> None:
        self.height = 2 * round(width * JAW_SIZE[1] / JAW_SIZE[0] / 2)
        self._canvas = film_canvas((width, self.height), JAW_SIZE)
        self._begun = False

    def draw(self, scene: Scene) -> NDArray[np.uint8]:
        """A new array (height, width, 3); all scenes must be of one model."""
        side, front = (0.0, 58.0, 320.0, 340.0), (320.0, 58.0, 320.0, 340.0)
        if not self._begun:
            self._canvas.rect((0, 0, *JAW_SIZE), palette.CARD)
            draw_backgrounds(self._canvas, side, front, scene)
            self._canvas.keep_as_background()
            self._begun = True
        self._canvas.restore()
        draw_views(self._canvas, side, front, scene)
        words = f"{known_in_words(scene)}, the worst within {100 * scene.belief_sd.max():.1f} %"
        self._canvas.text(f"{scene.time_s:.1f} s", (14, 20), 20, SOFT_INK)
        self._canvas.text(words, (626, 20), 20, INK, bold=True, anchor="right", fit=530)
        return self._canvas.pixels()


def film_canvas(size: tuple[int, int], design: tuple[int, int]) -> Canvas:
    """A canvas, for which pygame is needed."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    with needs("a film", "pygame", "render"):
        from jawenv.rendering.canvas import Canvas
    return Canvas(size, design)


def known_in_words(scene: Scene) -> str:
    """How many parameters are known."""
    return f"{int((scene.belief_sd <= KNOWN_SD).sum())} of {len(scene.belief_sd)} within {100 * KNOWN_SD:g} %"


def draw_backgrounds(canvas: Canvas, side: Box, front: Box, scene: Scene) -> None:
    """Draw the skull from both sides."""
    from jawenv.rendering.views import draw_front_background, draw_side_background

    draw_side_background(canvas, side_camera(side, scene.planar), side)
    draw_front_background(canvas, front_camera(front), front)
    for letter, x in (("R", front[0] + 14), ("L", front[0] + front[2] - 14)):
        canvas.text(letter, (x, front[1] + 168), 13, FAINT_INK, bold=True, anchor="centre")


def draw_views(canvas: Canvas, side: Box, front: Box, scene: Scene) -> None:
    """Draw the moving parts from both sides."""
    from jawenv.rendering.views import draw_front, draw_side

    draw_side(canvas, side_camera(side, scene.planar), side, scene)
    draw_front(canvas, front_camera(front), front, scene)
