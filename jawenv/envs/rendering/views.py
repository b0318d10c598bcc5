"""The jaw from the side and from the front, drawn from one set of surfaces with two cameras."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.envs.rendering import outlines, palette
from jawenv.envs.rendering.camera import FIXED, Camera, Pose, draw_mesh
from jawenv.envs.rendering.canvas import Box, Canvas
from jawenv.envs.rendering.muscles import draw_muscle, kind_of, muscle_colours, muscle_width
from jawenv.envs.rendering.scene import Scene

Array = NDArray[np.float64]

_BONE = palette.ramp(palette.BONE_SHADOW, palette.BONE_LIGHT, 32)
_TOOTH = palette.ramp(palette.TOOTH_SHADOW, palette.TOOTH_LIGHT, 32)
_PLATE = palette.ramp(palette.PLATE_SHADOW, palette.PLATE_LIGHT, 32)
_ARCH = outlines.closed(outlines.SIDE_ARCH)
_SIDE_TURN = np.radians(9.0)
_HEIGHT_MM = 164.0
_MM_PER_N = 1.3
_LONGEST_MM = 36.0
_LEAST_FORCE_N = 0.2
# Height of a muscle's name as a share of the view, place on the muscle it points at, start of its leader.
_NAME_PLACES = {
    "temporalis": (0.10, 0.22, (62.0, 2.0)),
    "medial_pterygoid": (0.76, 0.97, (44.0, -9.0)),
    "masseter": (0.90, 0.97, (56.0, -5.0)),
}
_BEHIND_BONE = "medial_pterygoid"
_UNDER_ARCH = "temporalis"


def side_camera(box: Box) -> Camera:
    """From the patient's right, turned a little to the front so that the far side shows."""
    c, s = np.cos(_SIDE_TURN), np.sin(_SIDE_TURN)
    x, y, width, height = box
    origin = (x + 0.29 * width, y + 0.285 * height)
    return Camera(np.array([c, s, 0.0]), np.array([s, -c, 0.0]), origin, height / _HEIGHT_MM)


def front_camera(box: Box) -> Camera:
    """Face to face with the patient: the patient's left is on the right."""
    x, y, width, height = box
    origin = (x + width / 2, y + 0.285 * height)
    return Camera(np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), origin, height / _HEIGHT_MM)


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
    near, far = _sides(scene)
    for index in far:
        _muscle(canvas, camera, scene, index, fade=0.5)
    draw_mesh(canvas, camera, outlines.mandible_half("left"), pose, _BONE, palette.BONE_LINE)
    draw_mesh(canvas, camera, outlines.lower_teeth(), pose, _TOOTH, palette.TOOTH_LINE)
    draw_mesh(canvas, camera, outlines.mandible_half("right"), pose, _BONE, palette.BONE_LINE)
    draw_mesh(canvas, camera, outlines.upper_teeth(), FIXED, _TOOTH, palette.TOOTH_LINE)
    _draw_plate(canvas, camera, scene)
    for index in [i for i in near if kind_of(scene.muscle_names[i]) == _BEHIND_BONE]:
        _muscle(canvas, camera, scene, index, alpha=150)
    for index in [i for i in near if kind_of(scene.muscle_names[i]) == _UNDER_ARCH]:
        _muscle(canvas, camera, scene, index)
    pixels = camera.project(np.insert(_ARCH, 1, -outlines.CONDYLE_Y_MM, axis=1))
    canvas.polygon(pixels, palette.SKULL, alpha=225)
    canvas.line(np.vstack([pixels, pixels[:1]]), palette.SKULL_LINE, 1.2)
    for index in [i for i in near if kind_of(scene.muscle_names[i]) not in (_BEHIND_BONE, _UNDER_ARCH)]:
        _muscle(canvas, camera, scene, index)
    _draw_path(canvas, camera, scene)
    _draw_names(canvas, camera, scene, box)
    _draw_force(canvas, camera, scene, box)
    canvas.clip(None)


def draw_front(canvas: Canvas, camera: Camera, box: Box, scene: Scene) -> None:
    """Draw the moving parts from the front, from the back to the face."""
    canvas.clip(box)
    pose = _pose(scene)
    kinds = [kind_of(name) for name in scene.muscle_names]
    for index in [i for i, kind in enumerate(kinds) if kind == _UNDER_ARCH]:
        _muscle(canvas, camera, scene, index)
    draw_mesh(canvas, camera, outlines.mandible(), pose, _BONE, palette.BONE_LINE)
    draw_mesh(canvas, camera, outlines.lower_teeth(), pose, _TOOTH, palette.TOOTH_LINE)
    for index in [i for i, kind in enumerate(kinds) if kind == _BEHIND_BONE]:
        _muscle(canvas, camera, scene, index, alpha=150)
    draw_mesh(canvas, camera, outlines.upper_teeth(), FIXED, _TOOTH, palette.TOOTH_LINE)
    for index in [i for i, kind in enumerate(kinds) if kind not in (_BEHIND_BONE, _UNDER_ARCH)]:
        _muscle(canvas, camera, scene, index)
    _draw_plate(canvas, camera, scene)
    _draw_midline(canvas, camera, scene, box)
    _draw_force(canvas, camera, scene, box)
    canvas.clip(None)


def _pose(scene: Scene) -> Pose:
    return Pose(scene.rotation, 1000 * scene.contact_m)


def _sides(scene: Scene) -> tuple[list[int], list[int]]:
    near = [i for i, name in enumerate(scene.muscle_names) if name.endswith("_right")]
    return near, [i for i in range(len(scene.muscle_names)) if i not in near]


def _muscle(canvas: Canvas, camera: Camera, scene: Scene, index: int, fade: float = 0.0, alpha: int = 255) -> None:
    start = camera.project(1000 * scene.muscle_origin_m[index])
    end = camera.project(1000 * scene.muscle_insertion_m[index])
    width = muscle_width(float(scene.muscle_tension_N[index]))
    draw_muscle(canvas, start, end, width, muscle_colours(scene)[index], fade=fade, alpha=alpha)


def _draw_plate(canvas: Canvas, camera: Camera, scene: Scene) -> None:
    pose = Pose(scene.rotation, 1000 * scene.mouthpiece_m)
    draw_mesh(canvas, camera, outlines.mouthpiece(), pose, _PLATE, palette.INK)


def _draw_path(canvas: Canvas, camera: Camera, scene: Scene) -> None:
    """Draw the condyle's path with the contact point on it, in the plane of the near condyle."""
    path = outlines.condyle_path(scene.fossa_drop_m, scene.fossa_frequency)
    canvas.line(camera.project(np.insert(path, 1, -outlines.CONDYLE_Y_MM, axis=1)), palette.FOSSA, 3.6)
    contact = 1000 * scene.contact_m * [1, 0, 1] - [0, outlines.CONDYLE_Y_MM, 0]
    x, y = camera.project(contact).tolist()
    canvas.circle((x, y), 4.4, palette.CARD)
    canvas.circle((x, y), 3.2, palette.INK)


def _draw_midline(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw the skull's midline, and how far to the side of it the mouthpiece is."""
    zero = camera.origin[0]
    bottom = box[1] + box[3] - 8
    canvas.dashes((zero, camera.origin[1] + 12), (zero, bottom), palette.SOFT_INK)
    aside_mm = 1000 * float(scene.mouthpiece_m[1])
    here = zero + aside_mm * camera.scale
    for grow, paint in ((2.0, palette.CARD), (0.0, palette.ACCENT)):
        canvas.line([(zero, bottom), (here, bottom)], paint, 2.6 + grow)
        canvas.line([(here, bottom - 5), (here, bottom + 5)], paint, 2.6 + grow)
    side = "left" if aside_mm > 0 else "right"
    words = f"jaw {abs(aside_mm):.1f} mm {side}" if abs(aside_mm) >= 0.05 else "jaw on the midline"
    canvas.text(words, (box[0] + box[2] - 14, box[1] - 14), 11.5, palette.ACCENT, bold=True, anchor="right")


def _draw_force(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Draw the device's force on the mandible as an arrow that starts at the mouthpiece, with its size."""
    force = scene.mouthpiece_force_N
    size = float(np.linalg.norm(force))
    if size < _LEAST_FORCE_N:
        return
    start = camera.project(1000 * scene.mouthpiece_m + 9 * scene.rotation[:, 0])
    flat = np.array([force @ camera.right, -force[2]])
    shown = float(np.hypot(*flat))
    low, high = np.array(box[:2]) + 12, np.array(box[:2]) + np.array(box[2:]) - 14
    if shown > 0.3 * size:
        reach = min(_MM_PER_N * shown, _LONGEST_MM) * camera.scale + 12
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


def _draw_end_on(canvas: Canvas, at: Array, toward: bool) -> None:
    """Draw a force along the line of sight: a dot in a ring toward the viewer, a cross in a ring away."""
    x, y = at.tolist()
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


def _draw_names(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Name the muscles of the near side; thin leaders come from the free space behind the jaw."""
    for name, start, end in zip(scene.muscle_names, scene.muscle_origin_m, scene.muscle_insertion_m, strict=True):
        kind = kind_of(name)
        if not name.endswith("_right") or kind not in _NAME_PLACES:
            continue
        share, along, leader = _NAME_PLACES[kind]
        x, y = box[0] + 16, box[1] + share * box[3]
        for line, word in enumerate(kind.split("_")):
            canvas.text(word, (x, y + 13 * line), 11.5, palette.SOFT_INK)
        target = camera.project(1000 * (start + (end - start) * along)).tolist()
        canvas.line([(x + leader[0], y + leader[1]), (target[0], target[1])], palette.SOFT_INK, 0.8)
