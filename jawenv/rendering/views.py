"""The jaw from the side and from the front, drawn from one set of surfaces with two cameras."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import outlines, palette
from jawenv.rendering.camera import FIXED, Camera, Pose, draw_mesh
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.condyles import draw_condyles_front, draw_condyles_side
from jawenv.rendering.force import draw_force
from jawenv.rendering.muscles import draw_muscle, layer_of, muscle_colours, muscle_width, side_of
from jawenv.rendering.names import draw_names
from jawenv.rendering.scene import Scene

Array = NDArray[np.float64]

_BONE = palette.ramp(palette.BONE_SHADOW, palette.BONE_LIGHT, 32)
_TOOTH = palette.ramp(palette.TOOTH_SHADOW, palette.TOOTH_LIGHT, 32)
_PLATE = palette.ramp(palette.PLATE_SHADOW, palette.PLATE_LIGHT, 32)
_ARCH = outlines.closed(outlines.SIDE_ARCH)


def draw_side(canvas: Canvas, camera: Camera, box: Box, scene: Scene) -> None:
    """Draw the moving parts from the side, from the far side to the near one."""
    canvas.clip(box)
    pose = _pose(scene)
    for index in _lines(scene, "left"):
        _muscle(canvas, camera, scene, index, fade=0.5)
    draw_mesh(canvas, camera, outlines.mandible_half("left"), pose, _BONE, palette.BONE_LINE)
    draw_mesh(canvas, camera, outlines.lower_teeth(), pose, _TOOTH, palette.TOOTH_LINE)
    draw_mesh(canvas, camera, outlines.mandible_half("right"), pose, _BONE, palette.BONE_LINE)
    draw_mesh(canvas, camera, outlines.upper_teeth(), FIXED, _TOOTH, palette.TOOTH_LINE)
    _draw_plate(canvas, camera, scene)
    for index in _lines(scene, "right", "middle", layer="inner"):
        _muscle(canvas, camera, scene, index, alpha=150)
    for index in _lines(scene, "right", "middle", layer="high"):
        _muscle(canvas, camera, scene, index)
    pixels = camera.project(np.insert(_ARCH, 1, -outlines.CONDYLE_Y_MM, axis=1))
    canvas.polygon(pixels, palette.SKULL, alpha=225)
    canvas.line(np.vstack([pixels, pixels[:1]]), palette.SKULL_LINE, 1.2)
    for index in _lines(scene, "right", "middle", layer="outer"):
        _muscle(canvas, camera, scene, index)
    draw_condyles_side(canvas, camera, scene, box)
    draw_names(canvas, camera, scene, box)
    draw_force(canvas, camera, scene, box)
    canvas.clip(None)


def draw_front(canvas: Canvas, camera: Camera, box: Box, scene: Scene) -> None:
    """Draw the moving parts from the front, from the back to the face."""
    canvas.clip(box)
    pose = _pose(scene)
    for index in _lines(scene, "left", "right", layer="high"):
        _muscle(canvas, camera, scene, index)
    draw_mesh(canvas, camera, outlines.mandible(), pose, _BONE, palette.BONE_LINE)
    draw_mesh(canvas, camera, outlines.lower_teeth(), pose, _TOOTH, palette.TOOTH_LINE)
    for index in _lines(scene, "left", "right", layer="inner"):
        _muscle(canvas, camera, scene, index, alpha=150)
    draw_mesh(canvas, camera, outlines.upper_teeth(), FIXED, _TOOTH, palette.TOOTH_LINE)
    for index in _lines(scene, "left", "right", layer="outer"):
        _muscle(canvas, camera, scene, index)
    for index in _lines(scene, "middle"):
        _muscle(canvas, camera, scene, index, alpha=190)
    draw_condyles_front(canvas, camera, scene, box)
    _draw_plate(canvas, camera, scene)
    _draw_midline(canvas, camera, scene, box)
    draw_force(canvas, camera, scene, box)
    canvas.clip(None)


def _lines(scene: Scene, *sides: str, layer: str = "") -> list[int]:
    """Lines of action on some sides and, if given, in one layer."""
    lines = [i for i in range(len(scene.muscle_names)) if side_of(scene, i) in sides]
    return [i for i in lines if not layer or layer_of(scene, i) == layer]


def _pose(scene: Scene) -> Pose:
    return Pose(scene.rotation, 1000 * scene.contact_m)


def _muscle(canvas: Canvas, camera: Camera, scene: Scene, index: int, fade: float = 0.0, alpha: int = 255) -> None:
    start = camera.project(1000 * scene.muscle_origin_m[index])
    end = camera.project(1000 * scene.muscle_insertion_m[index])
    width = muscle_width(float(scene.muscle_tension_N[index]))
    draw_muscle(canvas, start, end, width, muscle_colours(scene)[index], fade=fade, alpha=alpha)


def _draw_plate(canvas: Canvas, camera: Camera, scene: Scene) -> None:
    pose = Pose(scene.rotation, 1000 * scene.mouthpiece_m)
    draw_mesh(canvas, camera, outlines.mouthpiece(), pose, _PLATE, palette.INK)


def _draw_midline(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw the skull's midline, and how far to the side of it the mouthpiece is."""
    if scene.planar:
        return
    zero = camera.origin[0]
    bottom = box[1] + box[3] - 8
    canvas.dashes((zero, camera.origin[1] + 12), (zero, bottom), palette.SOFT_INK)
    aside_mm = 1000 * float(scene.mouthpiece_m[1])
    jaw_x = zero + aside_mm * camera.scale
    for grow, paint in ((2.0, palette.CARD), (0.0, palette.ACCENT)):
        canvas.line([(zero, bottom), (jaw_x, bottom)], paint, 2.6 + grow)
        canvas.line([(jaw_x, bottom - 5), (jaw_x, bottom + 5)], paint, 2.6 + grow)
    side = "left" if aside_mm > 0 else "right"
    label = f"jaw {abs(aside_mm):.1f} mm {side}" if abs(aside_mm) >= 0.05 else "jaw on the midline"
    canvas.text(label, (box[0] + box[2] - 14, box[1] - 14), 11.5, palette.ACCENT, bold=True, anchor="right")
