"""The jaw from the side and from the front, drawn from one set of surfaces with two cameras."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import outlines, palette
from jawenv.rendering.camera import FIXED, Camera, Pose, draw_mesh
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.muscles import draw_muscle, draw_names, layer_of, muscle_colours, muscle_width, side_of
from jawenv.rendering.palette import CARD, FOSSA, GOOD, INK, WARN
from jawenv.rendering.scene import Scene

Array = NDArray[np.float64]

_BONE = palette.ramp(palette.BONE_SHADOW, palette.BONE_LIGHT, 32)
_TOOTH = palette.ramp(palette.TOOTH_SHADOW, palette.TOOTH_LIGHT, 32)
_PLATE = palette.ramp(palette.PLATE_SHADOW, palette.PLATE_LIGHT, 32)
_ARCH = outlines.closed(outlines.SIDE_ARCH)
_LEFT, _RIGHT = 0, 1
_LIFTED_MM = 0.05  # below this a condyle counts as touching: discs and contacts begin softly
_HEAD_MM = np.linspace(-8.5, 8.5, 13)
MM_PER_N = 1.3
LONGEST_MM = 36.0
LEAST_FORCE_N = 0.2


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
    _draw_condyles_side(canvas, camera, scene, box)
    draw_names(canvas, camera, scene, box)
    _draw_force(canvas, camera, scene, box)
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
    _draw_condyles_front(canvas, camera, scene, box)
    _draw_plate(canvas, camera, scene)
    _draw_midline(canvas, camera, scene, box)
    _draw_force(canvas, camera, scene, box)
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


def _condyle_words(gap_mm: float) -> tuple[str, str]:
    """A condyle's state in words, and its lift if there is one."""
    return ("lifted off", f"{gap_mm:.1f} mm") if gap_mm > _LIFTED_MM else ("pressed", "")


def _draw_condyles_side(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw the path and the condyle on it in the plane of the near condyle."""
    if not scene.slides:
        _draw_pin(canvas, camera, scene)
        return
    path = 1000 * scene.path_m(outlines.PATH_X_MM / 1000)
    y = -outlines.CONDYLE_Y_MM
    curve = np.column_stack([outlines.PATH_X_MM, np.full_like(path, y), path])
    canvas.line(camera.project(curve), FOSSA, 3.6)
    centre = 1000 * scene.contact_m
    gap = 1000 * float(scene.condyle_gap_m[_RIGHT])
    lifted = scene.plant != "midline" and gap > _LIFTED_MM
    _draw_dot(canvas, camera.project(np.array([centre[0], y, centre[2]])), lifted)
    if scene.plant == "contact":
        words = f"condyle {' '.join(_condyle_words(gap))}".strip()
        ink = _ink(gap)
        canvas.text(words, (box[0] + box[2] - 14, box[1] - 14), 11.5, ink, bold=True, anchor="right")


def _draw_condyles_front(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw both fossae above their condyles."""
    heights = 1000 * scene.path_m(scene.contact_m[[0, 0]])
    for side, sign in ((_LEFT, 1), (_RIGHT, -1)):
        roof = heights[side] - 4.2 * (1 - np.sqrt(1 - (_HEAD_MM / 9.5) ** 2)) + 0.9
        across = sign * outlines.CONDYLE_Y_MM + _HEAD_MM
        canvas.line(camera.project(np.column_stack([np.zeros(len(roof)), across, roof])), FOSSA, 3.6)


def _ink(gap: float) -> palette.Colour:
    return palette.mix(WARN if gap > _LIFTED_MM else GOOD, INK, 0.2)


def _draw_dot(canvas: Canvas, position: Array, lifted: bool) -> None:
    """Draw where a condyle is: a filled dot on the path, an amber ring off it."""
    centre = (float(position[0]), float(position[1]))
    canvas.circle(centre, 5.0 if lifted else 4.4, CARD)
    canvas.circle(centre, 4.2 if lifted else 3.2, WARN if lifted else INK)
    if lifted:
        canvas.circle(centre, 2.0, CARD)


def _draw_pin(canvas: Canvas, camera: Camera, scene: Scene) -> None:
    """Draw the axis of a jaw that only turns."""
    centre = 1000 * scene.contact_m - [0, outlines.CONDYLE_Y_MM, 0]
    x, y = camera.project(centre).tolist()
    for radius, paint in ((9.0, CARD), (7.6, INK), (5.6, CARD), (2.6, INK)):
        canvas.circle((x, y), radius, paint)


def _draw_force(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
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
