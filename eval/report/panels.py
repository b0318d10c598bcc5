"""One panel per parameter: a line per muscle, and columns of F_o and b, left and right where muscles have sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from eval.comparison.results import Results
from eval.report import drawing
from jawenv.anatomy.muscles import SIDES

_SYMBOLS = {"log_F_o": r"$F_o$", "log_b": r"$b$"}
# Inches. Fixed margins: a dozen like panels need no search for a layout, which would take seconds.
_TOP, _BOTTOM, _LEFT, _RIGHT = 0.28, 0.48, 0.62, 0.12
_LONG = 34  # characters of a title that fit above a panel, TeX included
_FEW_LINES, _LINE, _LINE_OF_MANY = 3, 1.88, 1.4


@dataclass(frozen=True)
class Panel:
    """A parameter taken apart: `log_b/medial_pterygoid_left` is b of the medial pterygoid on the left.

    Attributes:
        symbol: `log_F_o` or `log_b`.
        muscle: without its side; empty where a whole side is one muscle.
        side: `left`, `right`, or empty for a muscle of both sides together.
    """

    symbol: str
    muscle: str
    side: str

    @classmethod
    def of(cls, parameter: str) -> Panel:
        """The panel of a parameter by its name."""
        symbol, muscle = parameter.split("/", 1)
        group, _, side = muscle.rpartition("_")
        return cls(symbol, group, side) if side in SIDES else cls(symbol, muscle, "")

    @property
    def title(self) -> str:
        """What stands above it."""
        return f"{self.muscle.replace('_', ' ')}  {_SYMBOLS[self.symbol]} {self.side}".strip()

    @property
    def plain_title(self) -> str:
        """The same without TeX, as `F_o of the masseter left`."""
        symbol = self.symbol.removeprefix("log_")
        return f"{symbol} of {self.muscle.replace('_', ' ')} {self.side}".strip().replace("of  ", "of ")


def sided(parameters: Sequence[str]) -> bool:
    """Whether muscles of the left and of the right are told apart."""
    return any(Panel.of(parameter).side for parameter in parameters)


def height(study: Results, head: float = 0.0) -> float:
    """Inches that the panels of a study take, below a head of so many."""
    lines = len({Panel.of(parameter).muscle for parameter in study.parameters})
    return head + _TOP + _BOTTOM + lines * (_LINE if lines <= _FEW_LINES else _LINE_OF_MANY)


def grid(figure: Figure, study: Results, head: float = 0.0) -> dict[str, Axes]:
    """Panels with common axes, by parameter, below a head of so many inches."""
    panels = {parameter: Panel.of(parameter) for parameter in study.parameters}
    lines = list(dict.fromkeys(panel.muscle for panel in panels.values()))
    columns = sorted(
        {(panel.symbol, panel.side) for panel in panels.values()},
        key=lambda column: (list(_SYMBOLS).index(column[0]), column[1]),
    )
    wide, high = figure.get_size_inches()
    axes = figure.subplots(
        len(lines),
        len(columns),
        sharex=True,
        sharey=True,
        squeeze=False,
        gridspec_kw={
            "left": _LEFT / wide,
            "right": 1.0 - _RIGHT / wide,
            "bottom": _BOTTOM / high,
            "top": 1.0 - (head + _TOP) / high,
            "wspace": 0.12,
            "hspace": 0.22,
        },
    )
    sd = study.curves[study.curves["quantity"].str.startswith("sd/")]
    longest = float(sd["time_s"].max())
    places = {}
    for parameter, panel in panels.items():
        place = axes[lines.index(panel.muscle), columns.index((panel.symbol, panel.side))]
        place.set_title(panel.title, fontsize=8.5 if len(panel.title) <= _LONG else 6.8)
        drawing.log_percent(place)
        place.set_xlim(0.0, longest)
        places[parameter] = place
    axes[0, 0].set_ylim(0.8 * float(np.nanmin(sd[["low", "bound"]].to_numpy())), 1.15 * float(sd["high"].max()))
    for place in axes[:, 0]:
        place.set_ylabel("sd")
    for place in axes[-1]:
        place.set_xlabel("time, s")
    return places
