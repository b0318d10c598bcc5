"""The device's force on the mandible, as an arrow with its size."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import palette
from jawenv.rendering.camera import Camera
from jawenv.rendering.scene import Scene

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Box, Canvas

Array = NDArray[np.float64]

MM_PER_N = 1.3
LONGEST_MM = 36.0
LEAST_FORCE_N = 0.2


def draw_force(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw the device's force on the mandible as an arrow that starts at the mouthpiece, with its size."""
    force = scene.mouthpiece_force_N
    size = float(np.linalg.norm(force))
    if size < LEAST_FORCE_N:
        return
    start = camera.project(1000 * scene.mouthpiece_m + 9 * scene.rotation[:, 0])
    flat = np.array([force @ camera.right, -force[2]])
    shown = float(np.hypot(*flat))
    low, high = np.array(box[:2]) + 12, np.array(box[:2]) + np.array(box[2:]) - 14
    if shown > 0.3 * size:
        reach = min(MM_PER_N * shown, LONGEST_MM) * camera.scale + 12
        tip = np.clip(start + flat / shown * reach, low, high)
        _draw_arrow(canvas, start, tip)
    else:
        tip = start
        _draw_end_on(canvas, start, bool(force @ camera.toward > 0))
    # The label stands below a sideways arrow and beside an upright one, where the card has room.
    if tip is start or abs(flat[0]) > abs(flat[1]):
        centre = tip + [0.0, 25.0]
    else:
        centre = tip + [36.0 if tip[0] + 62 < box[0] + box[2] else -36.0, -4.0]
    x, y = np.clip(centre, low + [16, 0], high - [16, 18]).tolist()
    canvas.rect((x - 24.5, y - 9.5, 49, 19), palette.CARD, radius=5, border=palette.BORDER)
    canvas.text(f"{size:.1f} N", (x, y), 12, palette.INK, bold=True, anchor="centre")


def _draw_end_on(canvas: Canvas, position: Array, toward: bool) -> None:
    """Draw a force along the line of sight: a dot in a ring toward the viewer, a cross in a ring away."""
    x, y = position.tolist()
    for radius, paint in ((9.5, palette.CARD), (8.0, palette.INK), (6.0, palette.CARD)):
        canvas.circle((x, y), radius, paint)
    if toward:
        canvas.circle((x, y), 2.6, palette.INK)
    else:
        for sign in (1, -1):
            canvas.line([(x - 3.6, y - 3.6 * sign), (x + 3.6, y + 3.6 * sign)], palette.INK, 1.8)


def _draw_arrow(canvas: Canvas, start: Array, tip: Array) -> None:
    """Draw a dark arrow with a light rim."""
    direction = (tip - start) / max(float(np.hypot(*(tip - start))), 1e-6)
    side, neck = np.array([-direction[1], direction[0]]), tip - direction * 9
    for rim, paint in ((1.4, palette.CARD), (0.0, palette.INK)):
        canvas.line(np.stack([start, neck]), paint, 3.0 + 2 * rim)
        wide, back = side * (5.5 + 1.7 * rim), neck - direction * rim
        canvas.polygon(np.stack([tip + direction * 2 * rim, back + wide, back - wide]), paint)
