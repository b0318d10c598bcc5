"""Whether an estimate can be believed, as one figure: a force that no muscle pulls, and poses that were left out."""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from eval.patient.charts import SD_95
from eval.report import drawing, template
from jawenv.recordings.untold.shown import Shown

SIZE = (520.0, 150.0)  # points
_LETTERS = 9.0  # points
FORCES = {"up": (2, "#9d3f1e"), "forwards": (0, "#2b5f8a")}
"""Components that are drawn, with their colours."""
_BAR, _LINE = "#9dbfe2", "#23272e"
_CSS = {_BAR: "var(--band)", _LINE: "var(--estimate)", "#9d3f1e": "var(--stiff)", "#2b5f8a": "var(--blocked)"}
AGREE = 1.1


def figure(shown: Shown) -> Markup:
    """Both panels side by side."""
    width, height = SIZE
    with drawing.style():
        drawn = Figure(figsize=(width / 72, height / 72), layout="constrained")
        left, right = drawn.subplots(1, 2)
        _draw_force(left, shown)
        _draw_poses(right, shown)
        label = "Force that no muscle pulls along the opening, and disagreement of each pose that was left out"
        return template.picture(drawn, "believed", label, _CSS)


def _draw_force(axes: Any, shown: Shown) -> None:
    opening = np.degrees(shown.opening)
    for name, (k, colour) in FORCES.items():
        reach = SD_95 * shown.force_sd[:, k]
        axes.fill_between(opening, shown.force[:, k] - reach, shown.force[:, k] + reach, color=colour, alpha=0.25, lw=0)
        axes.plot(opening, shown.force[:, k], color=colour, lw=1.5, label=name)
    axes.axhline(0.0, color=_LINE, lw=0.8)
    most = max(0.3, 1.1 * float(np.abs(axes.get_ylim()).max()))
    axes.set(ylim=(-most, most), xlabel="opening, °", ylabel="no muscle pulls, N")
    axes.legend(frameon=False, fontsize=_LETTERS)


def _draw_poses(axes: Any, shown: Shown) -> None:
    order = np.argsort(shown.pose_opening)
    axes.bar(np.arange(len(order)), shown.disagreement[order], color=_BAR)
    axes.axhline(1.0, color=_LINE, lw=1.0)
    openings = np.round(np.degrees(shown.pose_opening[order])) + 0.0  # no minus before a zero
    axes.set_xticks(np.arange(len(order)), [f"{opening:.0f}" for opening in openings])
    axes.set(xlabel="left-out pose, opening, °", ylabel="disagreement")
    if np.any(shown.disagreement > 10.0):
        axes.set_yscale("log")


def in_words(shown: Shown) -> str:
    """Sentence about how well the parts of the recording agree."""
    if shown.temperature < AGREE:
        return "Parts of the recording agree with each other as they should."
    wider = np.sqrt(shown.temperature)
    return (
        f"Parts of the recording disagree: something changes over time that the estimate does not know of. "
        f"All error bars are {wider:.1f} times as wide for it."
    )
