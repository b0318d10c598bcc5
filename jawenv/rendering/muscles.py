"""Muscles in pictures: spindles, as wide as their tension, in the colour of their sd; names and legends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import palette
from jawenv.rendering.camera import Camera
from jawenv.rendering.palette import FAINT_INK, SOFT_INK, Colour
from jawenv.rendering.scene import Scene

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Box, Canvas

Array = NDArray[np.float64]

SLACK, PER_ROOT_N, WIDEST = 3.0, 2.1, 17.0  # widths, design units: without tension, per root of a N, at most
_HIGH_MM = 15.0  # lines from above this height run under the cheekbone's arch
_INNER_MM = (1.0, 30.0)  # lines from between these distances to the midplane run inside the ramus
_SHORT = {"anterior": "ant.", "posterior": "post.", "medial": "med."}
_SIZE = 11.5
_LINE = 13.5
_ABOVE = (0.105, 0.195)  # heights of the names of high muscles, as shares of the view
_BELOW = (0.665, 0.96)  # between these stand the names of the others
_FEW_BELOW = (0.79, 0.92)
LABELLED_SD = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
LABELLED_TENSION_N = (1.0, 5.0, 20.0)
_PIECES = 80


def split_name(muscle: str) -> tuple[str, str]:
    """Name of a muscle without its side, and its side: `left`, `right` or nothing."""
    for side in ("left", "right"):
        if muscle == side or muscle.endswith(f"_{side}"):
            return muscle.removesuffix(side).rstrip("_"), side
    return muscle, ""


def side_of(scene: Scene, line: int) -> str:
    """Side that a line of action is on: `left`, `right` or `middle`."""
    return _side_at(scene.muscle_origin_m[line], scene.muscle_insertion_m[line], scene.planar)


def _side_at(origin: Array, insertion: Array, planar: bool) -> str:
    """Side of a line between two points (3,): `left`, `right` or, where all is in one plane, `middle`."""
    return "middle" if planar else "left" if origin[1] + insertion[1] > 0 else "right"


def layer_of(scene: Scene, line: int) -> str:
    """Layer in which a line runs, see `_layer_at`."""
    return _layer_at(1000 * scene.muscle_origin_m[line])


def _layer_at(origin_mm: Array) -> str:
    """Layer of a line from an origin: `high` under the arch, `inner` behind the ramus, `outer` on top of it."""
    _, y, z = origin_mm
    if z > _HIGH_MM:
        return "high"
    return "inner" if _INNER_MM[0] < abs(y) < _INNER_MM[1] else "outer"


def _muscle_sd(scene: Scene) -> list[float]:
    """Geometric mean of the two standard deviations (log F_o, log b) of every muscle."""
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    return [
        math.sqrt(scene.belief_sd[index[f"log_F_o/{name}"]] * scene.belief_sd[index[f"log_b/{name}"]])
        for name in scene.muscle_names
    ]


def muscle_colours(scene: Scene) -> list[Colour]:
    """Colour of every muscle."""
    return [palette.knowledge(sd) for sd in _muscle_sd(scene)]


def symbol(canvas: Canvas, parameter: str, at: tuple[float, float], size: float, colour: Colour) -> float:
    """Set the symbol of a parameter as in a formula (`log_F_o`: F with index o); return its width."""
    letter, _, index = parameter.removeprefix("log_").partition("_")
    width = canvas.text(letter, at, size, colour, bold=True)
    if index:
        below = (at[0] + width + 0.5, at[1] + 0.28 * size)
        width += canvas.text(index, below, 0.72 * size, colour, bold=True)
    return width


def muscle_width(tension_N: float) -> float:
    """Width of a muscle in design units, growing with the root of its tension."""
    return min(SLACK + PER_ROOT_N * math.sqrt(tension_N), WIDEST)


def draw_muscle(
    canvas: Canvas,
    start: Array,
    end: Array,
    width: float,
    colour: Colour,
    *,
    fade: float = 0.0,
    alpha: int = 255,
) -> None:
    """Draw a spindle.

    Args:
        canvas: where to draw.
        start: (2,) origin, design units.
        end: (2,) insertion.
        width: widest part.
        colour: colour of the belly.
        fade: share of paper mixed into it, for muscles of the far side.
        alpha: below 255 for muscles behind bone.
    """
    along = end - start
    length = max(float(np.hypot(*along)), 1e-6)
    across = np.array([-along[1], along[0]]) / length
    t = np.linspace(0, 1, 17)[:, None]
    profile = 0.40 + 0.60 * np.sin(np.pi * t) ** 0.8
    body = palette.mix(colour, palette.CARD, fade)
    rim = palette.mix(palette.mix(colour, palette.INK, 0.4), palette.CARD, fade)
    middle = start + along * t
    for half, paint in ((width / 2 + 0.9, rim), (width / 2, body)):
        side = across * half * profile
        canvas.polygon(np.vstack([middle + side, (middle - side)[::-1]]), paint, alpha)
    if alpha == 255 and width > 5:
        fibre = palette.mix(body, palette.CARD, 0.35)
        for lane in (-0.45, 0.0, 0.45):
            canvas.line((middle + across * (lane * width / 2) * profile)[2:-2], fibre, 0.7)
    for point in (start, end):
        canvas.circle((float(point[0]), float(point[1])), max(2.2, 0.26 * width), rim)


@dataclass
class _Name:
    """A muscle's name: its words, the places on its lines that leaders point at, and its rank among the names."""

    words: list[str]
    targets: list[tuple[float, float]]
    rank: float


def draw_names(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Name the muscles of the near side in the free space behind the jaw."""
    high: dict[str, _Name] = {}
    low: dict[str, _Name] = {}
    left, bottom = box[0] + 16, box[1] + box[3]
    for i, name in enumerate(scene.muscle_names):
        if side_of(scene, i) == "left":
            continue
        origin, insertion = scene.muscle_origin_m[i], scene.muscle_insertion_m[i]
        closed = (insertion - scene.contact_m) @ scene.rotation
        names = high if layer_of(scene, i) == "high" else low
        target = camera.project(1000 * (origin + (insertion - origin) * (0.2 if names is high else 0.97)))
        # Ranked in the closed jaw, so that no names change places while it moves; leaders then hardly cross.
        x, y = camera.project(1000 * closed)
        rank = -camera.project(1000 * origin)[0] if names is high else (x - left) / (bottom - y)
        label = names.setdefault(name, _Name(_words(name), [], float(rank)))
        label.targets.append((float(target[0]), float(target[1])))
    low_shares = np.linspace(*_BELOW, len(low)) if len(low) > 2 else np.array(_FEW_BELOW)[: len(low)]
    for shares, names in ((_ABOVE, high), (low_shares, low)):
        ranked = sorted(names.values(), key=lambda name: name.rank)
        _draw_column(canvas, (left, box[1]), [share * box[3] for share in shares[: len(ranked)]], ranked)


def _draw_column(canvas: Canvas, corner: tuple[float, float], heights: list[float], names: list[_Name]) -> None:
    """Set names below each other and draw a leader to each of their lines, clear of the other names."""
    rows = []
    for height, name in zip(heights, names, strict=False):
        for line, word in enumerate(name.words):
            y = corner[1] + height + _LINE * (line - (len(name.words) - 1) / 2)
            rows.append((name, line, y, canvas.text(word, (corner[0], y), _SIZE, palette.SOFT_INK)))
    edge = corner[0] + max((row[3] for row in rows), default=0.0) + 5
    for name, line, y, width in rows:
        if line == 0:
            for target in name.targets:
                points = [(corner[0] + width + 4, y), (max(edge, corner[0] + width + 5), y), target]
                canvas.line(points, palette.SOFT_INK, 0.8)


def _words(name: str) -> list[str]:
    if name in ("left", "right"):
        return [f"{name} side's", "muscles"]
    words = split_name(name)[0].split("_")
    return words if len(words) < 3 else [" ".join(_SHORT.get(word, word) for word in words[:-1]), words[-1]]


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
        tick = left + math.log(palette.UNKNOWN_SD / sd) / span * (right - left)
        canvas.line([(tick, y - 5), (tick, y + 5)], palette.CARD if 0.01 < sd < 0.5 else palette.BORDER, 1.0)
        canvas.text(f"{100 * sd:.0f} %", (tick, y + 12), 10, SOFT_INK, anchor="centre")


def draw_width_legend(canvas: Canvas, at: tuple[float, float]) -> None:
    """Muscles of some tensions, in a row that begins at ``at``."""
    x, y = at
    canvas.text("Muscle width: tension", (x, y), 10.5, SOFT_INK)
    for i, tension in enumerate(LABELLED_TENSION_N):
        left = x + 134 + i * 78
        draw_muscle(canvas, np.array([left, y]), np.array([left + 34.0, y]), muscle_width(tension), FAINT_INK)
        canvas.text(f"{tension:g} N", (left + 42, y), 10.5, SOFT_INK)
