"""What the colour and the width of a muscle mean."""

from __future__ import annotations

import math

import numpy as np

from jawenv.rendering import palette
from jawenv.rendering.canvas import Canvas
from jawenv.rendering.muscles import draw_muscle, muscle_width
from jawenv.rendering.palette import FAINT_INK, SOFT_INK

LABELLED_SD = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
LABELLED_TENSION_N = (1.0, 5.0, 20.0)
_PIECES = 80


def draw_colour_legend(canvas: Canvas, at: tuple[float, float], right: float) -> None:
    """The scale of knowledge, from ``at`` to the right edge."""
    x, y = at
    canvas.text("Muscle colour: sd", (x, y), 10.5, SOFT_INK)
    left = x + 112
    span = math.log(palette.UNKNOWN_SD / palette.KNOWN_SD)
    width = (right - left) / _PIECES
    for i in range(_PIECES):
        sd = palette.UNKNOWN_SD * math.exp(-span * (i + 0.5) / _PIECES)
        canvas.rect((left + i * width, y - 5, width + 0.6, 8), palette.knowledge(sd))
    for sd in LABELLED_SD:
        place = left + math.log(palette.UNKNOWN_SD / sd) / span * (right - left)
        canvas.line([(place, y - 5), (place, y + 5)], palette.CARD if 0.01 < sd < 0.5 else palette.BORDER, 1.0)
        canvas.text(f"{100 * sd:.0f} %", (place, y + 12), 10, SOFT_INK, anchor="centre")


def draw_width_legend(canvas: Canvas, at: tuple[float, float]) -> None:
    """Muscles of some tensions, in a row that begins at ``at``."""
    x, y = at
    canvas.text("Muscle width: tension", (x, y), 10.5, SOFT_INK)
    for i, tension in enumerate(LABELLED_TENSION_N):
        left = x + 134 + i * 78
        draw_muscle(canvas, np.array([left, y]), np.array([left + 34.0, y]), muscle_width(tension), FAINT_INK)
        canvas.text(f"{tension:g} N", (left + 42, y), 10.5, SOFT_INK)
