"""What all figures of docs/model.md share: colours, type, axes, the drawing of a mandible."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from jawenv.rendering import outlines

# Okabe & Ito's colours, which the colour-blind can tell apart; line styles differ as well.
INK, GREY, PALE = "#2b2f36", "#7d858f", "#e4e7eb"
BLUE, ORANGE, GREEN, PINK, SKY, RED = "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00"
STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": PALE,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.8,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "path",
    "svg.hashsalt": "jawenv",
    "mathtext.fontset": "dejavusans",
}
FORWARD, LEFT, UP = "x, forward (mm)", "y, left (mm)", "z, up (mm)"


def canvas(width: float, height: float, *shape: int, **options: object) -> tuple[Figure, list[Axes]]:
    """A figure and its axes in one list."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, list(np.atleast_1d(figure.subplots(*shape, **options)).ravel())


def bone(axes: Axes, first: int, second: int, turn: np.ndarray | None = None, shift: np.ndarray | None = None) -> None:
    """The mandible's drawing (mm) projected on two of the axes x, y, z; only the looks, no model."""
    left = outlines._RUNGS[:, :6].reshape(-1, 2, 3)
    ends = np.concatenate([left, left[::-1] * [1.0, -1.0, 1.0]])
    if turn is not None:
        ends = ends @ turn.T + shift
    flat = ends[:, :, [first, second]]
    quads = [np.array([a[0], a[1], b[1], b[0]]) for a, b in zip(flat[:-1], flat[1:], strict=True)]
    axes.add_collection(PolyCollection(quads, facecolors=PALE, edgecolors=PALE, linewidths=3.5, zorder=0))


def arrow(axes: Axes, start: np.ndarray, end: np.ndarray, colour: str, width: float = 1.6) -> None:
    """An arrow between two points."""
    style = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}
    axes.annotate("", end, start, arrowprops=style, zorder=4)


def plain(axes: Axes, title: str, xlabel: str, ylabel: str) -> None:
    """Equal scales, no grid."""
    axes.set(title=title, xlabel=xlabel, ylabel=ylabel, aspect="equal")
    axes.grid(False)
