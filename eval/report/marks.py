"""Traces and axes of the report's charts: marks with intervals, clouds of patients, lines over time.

Every trace of an entry has its number among the rows as ``meta``, by which the page hides and shows it.
"""

from __future__ import annotations

import math
import textwrap
from typing import Any

import numpy as np
import numpy.typing as npt

from eval.comparison.ranking import Ranking
from eval.comparison.results import Results
from eval.figures import words
from eval.figures.statistics import Interval
from eval.report import drawing
from eval.report.first import firsts

Array = npt.NDArray[np.float64]
Chart = dict[str, Any]

DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
SYMBOLS = ("circle", "square", "triangle-up", "cross", "star", "hexagon")
_ROW_PX, _MARGIN_PX = 34, 70
_POINTS = 100
_SD_TICKS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)


def entries(ranking: Ranking) -> list[dict[str, Any]]:
    """Name, place and look of every row, in their order; rows of one colour differ in dash and in marker."""
    colour, before, first = drawing.colours(ranking), drawing.repeats(ranking), {row.entry for row in firsts(ranking)}
    palette = list(dict.fromkeys(colour.values()))
    return [
        {
            "label": row.entry,
            "name": words.label(row.entry),
            "place": ranking.mark(row),
            "colour": colour[row.entry],
            "dash": DASHES[(palette.index(colour[row.entry]) + before[row.entry]) % len(DASHES)],
            "symbol": SYMBOLS[before[row.entry] % len(SYMBOLS)],
            "first": row.entry in first,
            "width": 3.0 if row.trained else 1.8,
            "ranked": not row.excluded,
        }
        for row in ranking.rows
    ]


def down(ranking: Ranking, traces: list[Chart], axis: Chart) -> Chart:
    """Entries on the vertical axis, the first at the top."""
    number = len(ranking.rows)
    names = ["<br>".join(textwrap.wrap(name, 20)) for name in drawing.names(ranking).values()]
    layout: Chart = {
        "xaxis": axis,
        "yaxis": {
            "tickvals": list(range(number)),
            "ticktext": names,
            "range": [number - 0.4, -0.6],
            "showgrid": False,
            "zeroline": False,
        },
        "height": _MARGIN_PX + _ROW_PX * number,
        "hovermode": "closest",
    }
    return {"data": traces, "layout": layout, "labels": False, "row_px": _ROW_PX}


def over_time(traces: list[Chart], axis: Chart, height: int) -> Chart:
    """Curves over the episode's time."""
    layout = {"xaxis": {"title": "time, s"}, "yaxis": axis, "height": height, "hovermode": "closest"}
    return {"data": traces, "layout": layout, "labels": True}


def sd_axis(title: str) -> Chart:
    """A logarithmic axis of sds, in percent."""
    ticks = {"tickvals": list(_SD_TICKS), "ticktext": [f"{100 * tick:g} %" for tick in _SD_TICKS]}
    return {"title": title, "type": "log", **ticks}


def look(ranking: Ranking, i: int) -> Chart:
    """Colour and symbol of an entry's markers."""
    entry = entries(ranking)[i]
    return {"color": entry["colour"], "symbol": entry["symbol"]}


def styled(ranking: Ranking, i: int, x: Array, y: Array, hover: str) -> Chart:
    """A line in the look of its entry."""
    entry = entries(ranking)[i]
    return {
        "x": plain(x),
        "y": plain(y),
        "mode": "lines",
        "name": entry["name"],
        "meta": i,
        "line": {"color": entry["colour"], "dash": entry["dash"], "width": entry["width"]},
        "hovertemplate": f"{entry['name']}<br>{hover}<extra></extra>",
    }


def line(study: Results, ranking: Ranking, i: int, quantity: str, hover: str) -> Chart:
    """Centre of a quantity over time."""
    table = thin(study, ranking.rows[i].entry, quantity)
    return styled(ranking, i, table["time_s"], table["centre"], f"{hover} at %{{x:.1f}} s")


def thin(study: Results, entry: str, quantity: str) -> dict[str, Array]:
    """One curve, thinned to the resolution of a panel."""
    table = study.curves[(study.curves["entry"] == entry) & (study.curves["quantity"] == quantity)]
    picked = table.iloc[np.unique(np.linspace(0, len(table) - 1, _POINTS).round().astype(int))]
    return {name: picked[name].to_numpy(dtype=np.float64) for name in ("time_s", "centre", "low", "high", "bound")}


def point(ranking: Ranking, i: int, x: float, y: float, interval: Interval, hover: str) -> Chart:
    """A dot with its interval."""
    colour = drawing.colours(ranking)[ranking.rows[i].entry]
    point = mark(i, x, y, {"size": 11} | look(ranking, i), hover)
    has_ends = interval.known and math.isfinite(interval.high)
    high, low = (max(interval.high - x, 0.0), max(x - interval.low, 0.0)) if has_ends else (0.0, 0.0)
    error = {"type": "data", "array": [high], "arrayminus": [low], "symmetric": False, "color": colour}
    return point | {"error_x": error | {"thickness": 3, "width": 0}}


def mark(i: int, x: float, y: float, marker: Chart, hover: str) -> Chart:
    """One marker."""
    trace: Chart = {"x": plain(np.array([x])), "y": plain(np.array([y])), "mode": "markers", "meta": i}
    return trace | {"marker": marker, "hovertemplate": f"{hover}<extra></extra>"}


def cloud(ranking: Ranking, i: int, values: Array, seeds: Array, unit: str) -> Chart:
    """A small dot per patient, spread across the upper part of the row so that none hides another."""
    across = i + np.random.default_rng(0).uniform(-0.36, 0.04, len(values))
    name = words.label(ranking.rows[i].entry)
    return {
        "x": plain(values),
        "y": plain(across),
        "mode": "markers",
        "meta": i,
        "marker": {"size": 5, "opacity": 0.45} | look(ranking, i),
        "customdata": [int(seed) for seed in seeds],
        "hovertemplate": f"{name}<br>patient of seed %{{customdata}}: {unit}<extra></extra>",
    }


def band(ranking: Ranking, axis: str) -> Chart:
    """Honest filters' NEES, across the chart."""
    low, high = ranking.band
    ends = {"x0": low, "x1": high, "y0": 0, "y1": 1} if axis == "x" else {"x0": 0, "x1": 1, "y0": low, "y1": high}
    other = "yref" if axis == "x" else "xref"
    return {
        "type": "rect",
        **ends,
        other: "paper",
        "fillcolor": drawing.BAND,
        "opacity": 0.3,
        "layer": "below",
        "line": {"width": 0},
    }


def plain(values: Array) -> list[float | None]:
    """Numbers for JSON: four significant digits, and nothing where there is none."""
    return [float(f"{value:.4g}") if math.isfinite(value) else None for value in values]
