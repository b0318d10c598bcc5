"""The look of every figure: sizes, colours for white and for black, and the colour of each entry."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import matplotlib as mpl

from eval.figures import words

if TYPE_CHECKING:
    from eval.comparison.ranking import Ranking

INK = "#3b3f46"
GRID = "#d3d7dd"
BAND = "#8fbf8f"
REFERENCE = "#8a9099"
_TRAINED = ("#d6336c", "#a61e4d", "#f783ac")
_OTHERS = ("#1f77c4", "#d55e00", "#009e73", "#7f6bd0", "#a67c00", "#2a93b0", "#8a6a4f", "#b0528a", "#7b8794")

_STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.edgecolor": REFERENCE,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.facecolor": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "xtick.minor.size": 0.0,
    "ytick.minor.size": 0.0,
    "legend.frameon": False,
    "figure.facecolor": "none",
    "savefig.facecolor": "none",
    "svg.fonttype": "none",
    "svg.hashsalt": "jawenv",  # ids that are the same in every run
    "lines.linewidth": 1.4,
    "lines.solid_capstyle": "round",
}


@contextmanager
def style() -> Iterator[None]:
    """Draw in the project's style."""
    with mpl.rc_context(_STYLE):
        yield


def colours(ranking: Ranking) -> dict[str, str]:
    """One colour per entry, the same in every figure; trained agents are pink."""
    trained, others = iter(_TRAINED * len(ranking.rows)), iter(_OTHERS * len(ranking.rows))
    return {row.entry: next(trained if row.trained else others) for row in ranking.rows}


def repeats(ranking: Ranking) -> dict[str, int]:
    """The number of entries before each with its colour."""
    seen: dict[str, int] = {}
    counts: dict[str, int] = {}
    for entry, colour in colours(ranking).items():
        counts[entry] = seen.get(colour, 0)
        seen[colour] = counts[entry] + 1
    return counts


def names(ranking: Ranking) -> dict[str, str]:
    """`3  slow opening` for every entry: its place, or a letter where it is not ranked, and its name."""
    return {row.entry: f"{ranking.mark(row)}  {words.label(row.entry)}" for row in ranking.rows}


def floor(ranking: Ranking) -> float:
    """Least true information that is drawn to scale: below it a single liar would flatten all others."""
    return -0.1 * max(row["information_claimed"].value for row in ranking.rows)
