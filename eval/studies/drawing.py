"""The performance profiles of a study as one figure."""

from __future__ import annotations

import math
from itertools import cycle
from pathlib import Path

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from eval.figures import words
from eval.report import drawing
from eval.studies.design import Design
from eval.studies.grid import FACTORS
from jawenv.base.files import atomic_write

_COLOURS = ("#3b82c4", "#e08a2c", "#3a9d5d", "#8b6cc6", "#d6336c", "#a5744b", "#2aa5a0", "#7b8794")
_DASHES = ("-", (0, (5, 2)), (0, (1, 1.5)))
_WIDTH, _PANEL_HEIGHT, _LEGEND_LINE = 9.0, 2.6, 0.2
_LEGEND_COLUMNS = 3


def draw(profiles: pd.DataFrame, design: Design, path: Path) -> None:
    """Draw the share of the patients within x, and within 5 % after x s, as SVG on white.

    Panels are settings, with a line per entry, or the other way round where there are more settings than entries.

    Args:
        profiles: of `eval.studies.estimates.profiles`.
        design: the study.
        path: of the file.
    """
    setting = [factor for factor in FACTORS if factor != "entry" and profiles[factor].nunique() > 1]
    table = profiles.assign(
        entry=profiles["entry"].map(words.label),
        setting=[", ".join(map(_text, levels[1:])) for levels in profiles[setting].itertuples()],
    )
    settings, entries = list(dict.fromkeys(table["setting"])), list(dict.fromkeys(table["entry"]))
    panel, line = ("setting", "entry") if len(settings) <= len(entries) else ("entry", "setting")
    panels = settings if panel == "setting" else entries
    lines = entries if line == "entry" else settings
    dashes = [dash for dash in _DASHES for _ in _COLOURS]
    styles = dict(zip(lines, zip(cycle(_COLOURS), cycle(dashes)), strict=False))
    above = _LEGEND_LINE * (1 + math.ceil(len(lines) / _LEGEND_COLUMNS))
    with drawing.style():
        figure = Figure(figsize=(_WIDTH, _PANEL_HEIGHT * len(panels) + above), layout="constrained")
        axes = figure.subplots(len(panels), 2, squeeze=False, sharey=True)
        for row, name in zip(axes, panels, strict=True):
            for key, of_line in table[table[panel] == name].groupby(line, sort=False):
                colour, dash = styles[str(key)]
                for ax, quantity in zip(row, ("worst_sd", "time_to_5"), strict=True):
                    curve = of_line[of_line["quantity"] == quantity]
                    ax.plot(curve["x"], curve["share"], color=colour, linestyle=dash, label=key)
            _name_axes(row[0], row[1], name, design)
        handles = {handle.get_label(): handle for ax in axes.flat for handle in ax.get_legend_handles_labels()[0]}
        if len(handles) > 1:
            figure.legend(handles=list(handles.values()), loc="outside upper left", ncols=_LEGEND_COLUMNS)
        with atomic_write(path) as unfinished:
            figure.savefig(unfinished, format="svg", facecolor="white", metadata={"Date": None})


def _text(level: object) -> str:
    return f"{level:g} steps/s" if isinstance(level, float) else str(level)


def _name_axes(precision: Axes, soon: Axes, name: str, design: Design) -> None:
    precision.set_title(name)
    drawing.log_percent(precision, "x")
    precision.set_xlabel("worst sd")
    precision.set_ylabel("share of the patients")
    precision.set_ylim(0.0, 1.02)
    soon.set_xlim(0.0, design.episode_s)
    soon.set_xlabel("time until the worst sd is 5 %, s")
