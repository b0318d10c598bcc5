"""The parts of the skull that never move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import outlines, palette
from jawenv.rendering.camera import Camera
from jawenv.rendering.canvas import Box, Canvas

Array = NDArray[np.float64]


def draw_side_background(canvas: Canvas, camera: Camera, box: Box) -> None:
    """Draw the parts of the skull that never move, seen from the side."""
    canvas.clip(box)
    for points, fill in ((outlines.SIDE_HEAD, palette.SKULL), (outlines.SIDE_ORBIT, palette.CARD)):
        curve = outlines.closed(points)
        _outline(canvas, camera.project(np.insert(curve, 1, 0.0, axis=1)), fill)
    _fade(canvas, box)
    canvas.clip(None)


def draw_front_background(canvas: Canvas, camera: Camera, box: Box) -> None:
    """Draw the parts of the skull that never move, seen from the front."""
    canvas.clip(box)
    _outline(canvas, camera.project(np.insert(outlines.face(), 0, 0.0, axis=1)), palette.SKULL)
    for sign in (1, -1):
        orbit = outlines.closed(outlines.FRONT_ORBIT) * [sign, 1]
        _outline(canvas, camera.project(np.insert(orbit, 0, 0.0, axis=1)), palette.CARD)
    nose = outlines.closed(outlines.mirrored(outlines.FRONT_NOSE)[:-1])
    _outline(canvas, camera.project(np.insert(nose, 0, 0.0, axis=1)), palette.CARD)
    _fade(canvas, box)
    canvas.clip(None)


def _fade(canvas: Canvas, box: Box) -> None:
    """Let the skull dissolve into the paper at the top and at the left and right edges."""
    x, y, width, height = box
    for i in range(16):
        for strip in (
            (x, y, width, 2.5 * (i + 1)),
            (x, y, 1.5 * (i + 1), height),
            (x + width - 1.5 * (i + 1), y, 1.5 * (i + 1), height),
        ):
            left, top, wide, high = strip
            corners = [(left, top), (left + wide, top), (left + wide, top + high), (left, top + high)]
            canvas.polygon(corners, palette.CARD, alpha=36)


def _outline(canvas: Canvas, points: Array, fill: palette.Colour) -> None:
    canvas.polygon(points, fill)
    canvas.line(np.vstack([points, points[:1]]), palette.SKULL_LINE, 1.2)
