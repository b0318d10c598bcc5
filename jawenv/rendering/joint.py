"""Joint posterior of the two parameters of a muscle: its ellipse inside that of the prior."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import palette
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.muscles import split_name, symbol
from jawenv.rendering.palette import FAINT_INK, GRID, INK, SOFT_INK, TRACK
from jawenv.rendering.scene import Scene

Array = NDArray[np.float64]

_SHOWN_SD = 2.6  # prior standard deviations to either side
_CONTOUR = 2.0
_LARGEST = 236.0
_CIRCLE = np.stack([np.cos(np.linspace(0, 2 * np.pi, 73)), np.sin(np.linspace(0, 2 * np.pi, 73))])


def draw_joint(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Draw one square per muscle, side by side; axes in prior standard deviations, labelled with values."""
    x, y, width, height = box
    count = len(scene.muscles)
    room = width / count
    side = min(height - 46, room - 44, _LARGEST)
    for number, muscle in enumerate(scene.muscles):
        left = x + (number + 0.5) * room - side / 2 + 14
        kind, which = split_name(muscle)
        words = (kind.replace("_", " ") if kind else f"{which} side").capitalize()
        canvas.text(
            "Joint posterior" if count == 1 else words,
            (left + side / 2, y + 7),
            11,
            SOFT_INK,
            anchor="centre",
            fit=max(room - 12, side),
        )
        _draw_pair(canvas, (left, y + 18), side, scene, muscle)


def _draw_pair(canvas: Canvas, corner: tuple[float, float], side: float, scene: Scene, muscle: str) -> None:
    pair = [scene.parameter_names.index(f"{symbol}/{muscle}") for symbol in ("log_F_o", "log_b")]
    mean, sd = scene.prior_mean[pair], scene.prior_sd[pair]
    middle = np.array(corner) + side / 2

    def place(points: Array) -> Array:
        """Places of natural logs (N, 2), held at the square's edge."""
        shares = np.clip((points - mean) / sd / _SHOWN_SD, -1, 1)
        placed: Array = middle + shares * [side / 2, -side / 2]
        return placed

    canvas.rect((*corner, side, side), palette.CARD, radius=4, border=palette.BORDER)
    _draw_scales(canvas, corner, side, mean, sd)
    canvas.polygon(place(mean + _CONTOUR * _CIRCLE.T * sd), TRACK)
    covariance = scene.belief_cov[np.ix_(pair, pair)]
    values, axes = np.linalg.eigh(covariance)
    ring = _CONTOUR * (axes * np.sqrt(np.maximum(values, 0.0))) @ _CIRCLE
    colour = palette.knowledge(math.sqrt(float(scene.belief_sd[pair[0]] * scene.belief_sd[pair[1]])))
    outline = place(scene.belief_mean[pair] + ring.T)
    canvas.polygon(outline, colour)
    canvas.line(outline, palette.mix(colour, INK, 0.35), 1.4)
    if scene.truth is not None:
        x, y = place(scene.truth[pair]).tolist()
        draw_truth_ring(canvas, x, y)


def draw_truth_ring(canvas: Canvas, x: float, y: float) -> None:
    """Draw a ring around the truth, so that a posterior inside it can be seen."""
    ring = 5.0 * _CIRCLE.T + [x, y]
    for width, paint in ((3.4, palette.CARD), (1.7, INK)):
        canvas.line(ring, paint, width)


def _draw_scales(canvas: Canvas, corner: tuple[float, float], side: float, mean: Array, sd: Array) -> None:
    """Grid lines at the prior's median and one and two standard deviations from it, with values of F_o and b."""
    x, y = corner
    for sds in (-2, -1, 0, 1, 2):
        share = 0.5 + sds / (2 * _SHOWN_SD)
        canvas.line([(x + share * side, y + 2), (x + share * side, y + side - 2)], GRID, 0.8)
        canvas.line([(x + 2, y + share * side), (x + side - 2, y + share * side)], GRID, 0.8)
        if sds % 2 == 0:
            force, stiffness = np.exp(mean + sds * sd).tolist()
            canvas.text(f"{force:.2g}", (x + share * side, y + side + 8), 9.5, SOFT_INK, anchor="centre")
            canvas.text(f"{stiffness:.2g}", (x - 5, y + (1 - share) * side), 9.5, SOFT_INK, anchor="right")
    used = symbol(canvas, "log_F_o", (x + side / 2 - 14, y + side + 21), 11, INK)
    canvas.text("N", (x + side / 2 - 10 + used, y + side + 21), 10, FAINT_INK)
    symbol(canvas, "log_b", (x - 34, y + side / 2), 11, INK)
