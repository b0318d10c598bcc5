"""The jaw and its closing muscles from both sides, as SVG; colours are classes that the page defines."""

from __future__ import annotations

import html
from collections.abc import Mapping

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from eval.figures import words
from jawenv.anatomy import MuscleSet
from jawenv.metrics.verdicts import BOTH, NO_VERDICT, OPEN
from jawenv.rendering import outlines
from jawenv.rendering.mesh import Mesh

Array = NDArray[np.float64]

WIDTH, HEIGHT = 204.0, 154.0  # mm
_TOP, _BACK = 66.0, -92.0  # upper edge and rear edge of the picture in the head's frame, mm
_BELLY_MM = {"temporalis": 15.0, "masseter": 14.0, "medial_pterygoid": 10.0}
_MUSCLE_ORDER = ("medial_pterygoid", "temporalis", "masseter")  # from the inside out
# Where a muscle's name stands: its left end (mm in the picture), and which share of the way from origin to insertion
# its leader points at.
_NAMES = {
    "temporalis": ((4.0, 30.0), 0.4),
    "masseter": ((4.0, 99.0), 0.5),
    "medial_pterygoid": ((4.0, 125.0), 0.9),
}
_LETTER_MM, _GAP_MM = 4.1, 2.0


class _Side:
    """Orthographic view of one side of the head; the face looks to the outside of the page's middle.

    Args:
        side: `left` or `right`, the patient's.
    """

    def __init__(self, side: str) -> None:
        self.side = side
        self._sign = -1.0 if side == "left" else 1.0

    def place(self, points_mm: Array) -> Array:
        """(..., 2) in the picture of (..., 3) in the head's frame."""
        across = points_mm[..., 0] - _BACK
        return np.stack([across if self._sign > 0 else WIDTH - across, _TOP - points_mm[..., 2]], axis=-1)

    def flat(self, outline_mm: Array) -> str:
        """Path of a closed outline (N, 2) of x and z."""
        return _path(self.place(np.insert(outline_mm, 1, 0.0, axis=1)))

    def silhouette(self, mesh: Mesh) -> str:
        """Path of all faces that look to the viewer; filled, they are the silhouette."""
        facing = mesh.normals[:, 1] * -self._sign > 0.0
        return "".join(_path(self.place(mesh.vertices[face])) for face in mesh.faces[facing])


def _path(points: Array) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + "Z"


def view(side: str, muscles: MuscleSet, verdict_words: Mapping[str, str]) -> Markup:
    """One side of the head with its closing muscles.

    Args:
        side: `left` or `right`, the patient's.
        muscles: muscle set to draw, jaw closed.
        verdict_words: muscle -> verdict, one of `verdicts.WORDS` or `verdicts.NO_VERDICT`.
    """
    shown = _Side(side)
    spoken = ", ".join(f"{words.label(name)}: {word}" for name, word in verdict_words.items() if name.endswith(side))
    parts = [
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" class="jaw" role="img" xmlns="http://www.w3.org/2000/svg" '
        f'aria-label="{html.escape(f"The patient’s {side} side: {spoken}")}">',
        f'<path class="skull" d="{shown.flat(outlines.closed(outlines.SIDE_HEAD))}"/>',
        f'<path class="orbit" d="{shown.flat(outlines.closed(outlines.SIDE_ORBIT))}"/>',
    ]
    lines = {name: (muscles.origin_m[i] * 1e3, muscles.insertion_m[i] * 1e3) for i, name in enumerate(muscles.names)}
    for kind in _MUSCLE_ORDER:
        if kind == "temporalis":
            parts += _bones(shown)
        name = f"{kind}_{side}"
        parts.append(_belly(shown, kind, lines[name], verdict_words[name]))
        if kind == "temporalis":
            parts.append(f'<path class="skull" d="{shown.flat(outlines.closed(outlines.SIDE_ARCH))}"/>')
    # The inner muscle shows through the bone as an outline.
    inner = f"medial_pterygoid_{side}"
    parts.append(_belly(shown, "medial_pterygoid", lines[inner], verdict_words[inner], "behind"))
    parts += [_name(shown, kind, lines[f"{kind}_{side}"], verdict_words[f"{kind}_{side}"]) for kind in _NAMES]
    return Markup("".join([*parts, "</svg>"]))  # noqa: S704  (numbers, our own words, and an escaped label)


def _bones(shown: _Side) -> list[str]:
    half = shown.silhouette(outlines.mandible_half(shown.side))
    teeth = "".join(shown.silhouette(mesh) for mesh in (outlines.lower_teeth(), outlines.upper_teeth()))
    drawn = []
    for kind, path in (("bone", half), ("tooth", teeth)):
        # A wide line below, then the faces without one: only the contour of the line stays visible.
        drawn += [f'<path class="{kind} edge" d="{path}"/>', f'<path class="{kind}" d="{path}"/>']
    return drawn


def _belly(shown: _Side, kind: str, line: tuple[Array, Array], word: str, more: str = "") -> str:
    """A spindle from origin to insertion."""
    start, end = shown.place(line[0]), shown.place(line[1])
    along = end - start
    across = np.array([-along[1], along[0]]) / np.hypot(*along)
    t = np.linspace(0.0, 1.0, 15)[:, None]
    half = 0.5 * _BELLY_MM[kind] * (0.35 + 0.65 * np.sin(np.pi * t) ** 0.8) * across
    middle = start + t * along
    outline = _path(np.vstack([middle + half, (middle - half)[::-1]]))
    return f'<path class="belly {class_of(word)} {more}" d="{outline}"/>'


def _name(shown: _Side, kind: str, line: tuple[Array, Array], word: str) -> str:
    """Name and verdict of a muscle, with a leader to its belly."""
    (x, y), share = _NAMES[kind]
    at = shown.place(line[0] + share * (line[1] - line[0]))
    label = words.label(kind).capitalize()
    width = _LETTER_MM * len(label) + _GAP_MM
    ends = x + width, at[0]
    anchor = "start"
    if shown.side == "left":
        x, anchor, ends = WIDTH - x, "end", (WIDTH - x - width, at[0])
    return (
        f'<path class="leader" d="M{ends[0]:.1f} {y - 2.5:.1f}L{at[0]:.1f} {at[1]:.1f}"/>'
        f'<circle class="leader" cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="1.2"/>'
        f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}">{label}</text>'
        f'<text x="{x:g}" y="{y + 8.5:g}" text-anchor="{anchor}" class="said {class_of(word)}">{word}</text>'
    )


def class_of(word: str) -> str:
    """CSS class of a verdict."""
    return "unknown" if word in (NO_VERDICT, *OPEN) else {BOTH: "both"}.get(word, word)
