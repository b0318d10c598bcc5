"""How a muscle looks: a spindle, as wide as its tension asks, in the colour of what is known about it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import palette
from jawenv.rendering.palette import Colour
from jawenv.rendering.scene import Scene

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Canvas

Array = NDArray[np.float64]


SLACK, PER_ROOT_N, WIDEST = 3.0, 2.1, 17.0  # widths, design units: without tension, per root of a N, at most
_HIGH_MM = 15.0  # lines from above this height run under the cheekbone's arch
_INNER_MM = (1.0, 30.0)  # lines from between these distances to the midplane run inside the ramus


def split_name(muscle: str) -> tuple[str, str]:
    """Name of a muscle without its side, and its side: `left`, `right` or nothing."""
    for side in ("left", "right"):
        if muscle == side or muscle.endswith(f"_{side}"):
            return muscle.removesuffix(side).rstrip("_"), side
    return muscle, ""


def side_of(scene: Scene, line: int) -> str:
    """Side that a line of action is on: `left`, `right` or `middle`."""
    return side_at(scene.muscle_origin_m[line], scene.muscle_insertion_m[line], scene.planar)


def side_at(origin: Array, insertion: Array, planar: bool) -> str:
    """Side of a line between two points (3,): `left`, `right` or, where all is in one plane, `middle`."""
    return "middle" if planar else "left" if origin[1] + insertion[1] > 0 else "right"


def layer_of(scene: Scene, line: int) -> str:
    """How deep a line runs, see `layer_at`."""
    return layer_at(1000 * scene.muscle_origin_m[line])


def layer_at(origin_mm: Array) -> str:
    """How deep a line from an origin runs: `high` under the arch, `inner` behind the ramus, `outer` on top of it."""
    _, y, z = origin_mm
    if z > _HIGH_MM:
        return "high"
    return "inner" if _INNER_MM[0] < abs(y) < _INNER_MM[1] else "outer"


def muscle_sd(scene: Scene) -> list[float]:
    """Geometric mean of the two standard deviations (log F_o, log b) of every muscle."""
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    return [
        math.sqrt(scene.belief_sd[index[f"log_F_o/{name}"]] * scene.belief_sd[index[f"log_b/{name}"]])
        for name in scene.muscle_names
    ]


def muscle_colours(scene: Scene) -> list[Colour]:
    """Colour of every muscle."""
    return [palette.knowledge(sd) for sd in muscle_sd(scene)]


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
