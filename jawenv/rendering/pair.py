"""Two episodes in step in one picture, half a picture each: the jaw from two sides, and what is known so far."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from jawenv.extras import needs
from jawenv.rendering.scene import Scene

KNOWN_SD = 0.05
"""What counts as known: the ranking's target."""


class PairRenderer:
    """Draws two scenes beside each other, off-screen.

    Args:
        size: width and height of the pictures in pixels.
    """

    def __init__(self, size: tuple[int, int] = (1280, 720)) -> None:
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
        with needs("a film", "pygame", "render"):
            from jawenv.rendering.canvas import Canvas

        self._canvas = Canvas(size)
        self._canvas.keep_as_background()

    def draw(self, left: Scene, right: Scene) -> NDArray[np.uint8]:
        """A new array (height, width, 3); the scenes' titles stand above their halves."""
        import pygame

        from jawenv.rendering.half import draw_footer, draw_half

        self._canvas.restore()
        for place, scene in enumerate((left, right)):
            draw_half(self._canvas, 640.0 * place, scene, KNOWN_SD)
        draw_footer(self._canvas, max(left, right, key=lambda scene: scene.time_s))
        surface = self._canvas.finish()
        pixels = np.frombuffer(pygame.image.tobytes(surface, "RGB"), dtype=np.uint8)
        return pixels.reshape(self._canvas.size[1], self._canvas.size[0], 3).copy()
