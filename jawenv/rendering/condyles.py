"""The condyles on their fossae: bound to the path, turning on a pin, or free to press and to lift off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import outlines, palette
from jawenv.rendering.camera import Camera
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.palette import CARD, FOSSA, GOOD, INK, WARN
from jawenv.rendering.scene import Scene

Array = NDArray[np.float64]

_LEFT, _RIGHT = 0, 1
_LIFTED_MM = 0.05  # below this a condyle counts as touching: discs and contacts begin softly
_HEAD_MM = np.linspace(-8.5, 8.5, 13)


def condyle_words(gap_mm: float) -> tuple[str, str]:
    """What a condyle does, and how far it is lifted if it is."""
    return ("lifted off", f"{gap_mm:.1f} mm") if gap_mm > _LIFTED_MM else ("pressed", "")


def draw_condyles_side(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw the path and the condyle on it in the plane of the near condyle; with two condyles, the far one too."""
    if not scene.slides:
        _draw_pin(canvas, camera, scene)
        return
    path = 1000 * scene.path_m(outlines.PATH_X_MM / 1000)
    sides = (_LEFT, _RIGHT) if scene.plant == "bilateral" else (_RIGHT,)
    for side in sides:
        y = outlines.CONDYLE_Y_MM * (1 if side == _LEFT else -1)
        fade = 0.55 if side == _LEFT else 0.0
        curve = np.column_stack([outlines.PATH_X_MM, np.full_like(path, y), path])
        canvas.line(camera.project(curve), palette.mix(FOSSA, CARD, fade), 3.6)
        place = 1000 * (scene.contact_m if scene.plant != "bilateral" else scene.condyles_m[side])
        gap = 1000 * float(scene.condyle_gap_m[side])
        lifted = scene.plant != "midline" and gap > _LIFTED_MM
        _draw_dot(canvas, camera.project(np.array([place[0], y, place[2]])), lifted, fade)
    if scene.plant == "contact":
        words = f"condyle {' '.join(condyle_words(gap))}".strip()
        ink = _ink(gap)
        canvas.text(words, (box[0] + box[2] - 14, box[1] - 14), 11.5, ink, bold=True, anchor="right")


def draw_condyles_front(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw both fossae above their condyles; where condyles can lift off, say whether they do."""
    heights = 1000 * scene.path_m(scene.condyles_m[:, 0] if scene.plant == "bilateral" else scene.contact_m[[0, 0]])
    for side, sign in ((_LEFT, 1), (_RIGHT, -1)):
        roof = heights[side] - 4.2 * (1 - np.sqrt(1 - (_HEAD_MM / 9.5) ** 2)) + 0.9
        across = sign * outlines.CONDYLE_Y_MM + _HEAD_MM
        canvas.line(camera.project(np.column_stack([np.zeros(len(roof)), across, roof])), FOSSA, 3.6)
        if scene.plant == "bilateral":
            _draw_state(canvas, camera, box, sign, 1000 * float(scene.condyle_gap_m[side]))


def _draw_state(canvas: Canvas, camera: Camera, box: Box, sign: int, gap: float) -> None:
    """Say beside a condyle whether it presses on its disc."""
    x, y = camera.project(np.array([0.0, sign * 67.0, -19.0])).tolist()
    x = min(max(x, box[0] + 32), box[0] + box[2] - 32)
    for line, words in enumerate(filter(None, condyle_words(gap))):
        canvas.text(words, (x, y + 13 * line), 11, _ink(gap), bold=True, anchor="centre")


def _ink(gap: float) -> palette.Colour:
    return palette.mix(WARN if gap > _LIFTED_MM else GOOD, INK, 0.2)


def _draw_dot(canvas: Canvas, position: Array, lifted: bool, fade: float) -> None:
    """Draw where a condyle is: a filled dot on the path, an amber ring off it."""
    centre = (float(position[0]), float(position[1]))
    canvas.circle(centre, 5.0 if lifted else 4.4, CARD)
    canvas.circle(centre, 4.2 if lifted else 3.2, palette.mix(WARN if lifted else INK, CARD, fade))
    if lifted:
        canvas.circle(centre, 2.0, CARD)


def _draw_pin(canvas: Canvas, camera: Camera, scene: Scene) -> None:
    """Draw the axis of a jaw that only turns."""
    place = 1000 * scene.contact_m - [0, outlines.CONDYLE_Y_MM, 0]
    x, y = camera.project(place).tolist()
    for radius, paint in ((9.0, CARD), (7.6, INK), (5.6, CARD), (2.6, INK)):
        canvas.circle((x, y), radius, paint)
