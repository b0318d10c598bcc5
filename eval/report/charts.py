"""The charts of the report as plotly's traces and axes; `assets/charts.js` draws them in the colours of the page.

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
from eval.rows.outcomes import NEES_QUANTILES
from jawenv.metrics import TARGETS

Array = npt.NDArray[np.float64]
Chart = dict[str, Any]

DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
SYMBOLS = ("circle", "square", "triangle-up", "cross", "star", "hexagon")
_ROW_PX, _MARGIN_PX = 34, 70
_POINTS = 100
_SD_TICKS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
_BELOW = 0.27  # of a row: where a second mark stands, so that the first does not hide it
_LEAST_DISCOMFORT = 1e-3  # s per 30 s: floor of the log axis
_COARSE, _FINE = (1, 1.5, 2, 3, 5, 7), (1, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)
_NARROW = 3.0  # highest over lowest NEES of a chart, below which it needs the finer marks


def all_charts(study: Results, ranking: Ranking) -> dict[str, Chart]:
    """Every chart that shows all entries, by the id of its place on the page."""
    charts = {
        "information": information(ranking),
        "worst_sd": worst_sd(study, ranking),
        "nees": nees(ranking),
        "nees_over_time": nees_over_time(study, ranking),
        "discomfort": discomfort(ranking),
    }
    charts |= {f"reached_{100 * target:g}": _reached(study, ranking, target) for target in TARGETS}
    return charts


def information(ranking: Ranking) -> Chart:
    """True information with its interval, claimed information, and the bound where there is one."""
    floor = drawing.floor(ranking)
    traces = []
    for i, row in enumerate(ranking.rows):
        true, claimed, bound = (row[f"information_{kind}"] for kind in ("true", "claimed", "bound"))
        name = words.label(row.entry)
        hover = f"{name}<br>true {words.with_interval(true)} nats<br>claimed {words.number(claimed.value)}"
        below = true.value < floor
        dot = _point(ranking, i, max(true.value, floor), i, true, hover)
        if below:
            dot |= {"mode": "markers+text", "text": [words.number(true.value, 0)], "textposition": "middle right"}
            dot["marker"] |= {"symbol": "triangle-left", "size": 13}
            del dot["error_x"]
        if ranking.has_bound and np.isfinite(bound.value):
            tick = {"symbol": "line-ns-open", "size": 20, "line": {"width": 2}}
            traces.append(_mark(i, bound.value, i, tick, f"{name}<br>bound %{{x:.1f}} nats"))
        traces.append(dot)
        shape = {"symbol": "diamond-open", "size": 8, "color": drawing.colours(ranking)[row.entry]}
        traces.append(_mark(i, claimed.value, i + _BELOW, shape, f"{name}<br>claimed %{{x:.1f}} nats"))
    return _down(ranking, traces, {"title": "information, nats (more is better)", "zeroline": True})


def worst_sd(study: Results, ranking: Ranking) -> Chart:
    """The worst sd of every patient, and its median."""
    traces = []
    for i, row in enumerate(ranking.rows):
        table = study.of(row.entry)
        traces.append(_cloud(ranking, i, table["worst_sd"].to_numpy(), table["seed"].to_numpy(), "%{x:.1%}"))
        median = row["worst_sd"]
        hover = f"{words.label(row.entry)}<br>median {words.percent(median.value)} %"
        traces.append(_point(ranking, i, median.value, i + _BELOW, median, hover))
    return _down(ranking, traces, _sd_axis(f"worst of the {ranking.n_parameters} sd at the end (less is better)"))


def nees(ranking: Ranking) -> Chart:
    """Mean NEES of every entry, with the band of calibrated filters."""
    traces = []
    for i, row in enumerate(ranking.rows):
        mean = row["nees"]
        hover = f"{words.label(row.entry)}<br>mean NEES {words.with_interval(mean)}: {ranking.calibration(row)}"
        traces.append(_point(ranking, i, mean.value, i, mean, hover))
    chart = _down(ranking, traces, {"title": "mean NEES at the end", "type": "log", **_nees_ticks(ranking)})
    chart["layout"]["shapes"] = [_band(ranking, "x")]
    return chart


def nees_over_time(study: Results, ranking: Ranking) -> Chart:
    """NEES of every entry over time: mean, and of the first ones median and 90 %; with the calibrated band of means."""
    traces = [_line(study, ranking, i, "nees", "mean NEES %{y:.1f}") for i in range(len(ranking.rows))]
    for row in firsts(ranking):
        for (quantity, share), dash in zip(NEES_QUANTILES.items(), ("dot", "dash"), strict=True):
            name = f"NEES, {100.0 * share:.0f} % of the patients below, %{{y:.1f}}"
            thin = _line(study, ranking, ranking.rows.index(row), quantity, name)
            traces.append(thin | {"line": thin["line"] | {"dash": dash, "width": 1}})
    title = "NEES: mean, median (dots), 90 % (dashes)"
    chart = _over_time(traces, {"title": title, "type": "log", **_nees_ticks(ranking)}, 380)
    chart["layout"]["shapes"] = [_band(ranking, "y")]
    return chart


def _nees_ticks(ranking: Ranking) -> Chart:
    """Marks of an axis of NEES, so close that the chart shows two at least."""
    means = [row["nees"] for row in ranking.rows]
    shown = [end for mean in means for end in (mean.value, mean.low, mean.high) if end > 0.0]
    narrow = not shown or max(shown) < _NARROW * min(shown)
    return {"tickvals": [round(factor * 10.0**k, 6) for k in range(-1, 7) for factor in (_FINE if narrow else _COARSE)]}


def _reached(study: Results, ranking: Ranking, target: float) -> Chart:
    """Share of the patients with a worst sd at or below a target, over time."""
    longest = float(study.patients["duration_s"].max())
    traces = []
    for i, row in enumerate(ranking.rows):
        seconds = np.sort(study.of(row.entry)[f"time_to_{target:g}_s"].to_numpy())
        times = seconds[np.isfinite(seconds)]
        time = np.concatenate([[0.0], times, [longest]])
        share = np.concatenate([[0.0], np.arange(1, len(times) + 1), [len(times)]]) / len(seconds)
        trace = _styled(ranking, i, time, 100.0 * share, "%{y:.0f} % at %{x:.1f} s")
        trace["line"]["shape"] = "hv"
        traces.append(trace)
    return _over_time(traces, {"title": "patients, %", "range": [-3.0, 104.0]}, 330)


def discomfort(ranking: Ranking) -> Chart:
    """True information against discomfort, with the line beyond which nobody is ranked."""
    traces = []
    for i, row in enumerate(ranking.rows):
        cost, violated = row["discomfort_rate"].value, words.percent(row["violated"].value)
        hover = (
            f"{words.label(row.entry)}<br>discomfort {cost:.3g} s per 30 s<br>"
            f"hard limit crossed in {violated} % of the episodes"
        )
        marker = {"size": 11, "opacity": 0.8} | _look(ranking, i)
        traces.append(_mark(i, max(cost, _LEAST_DISCOMFORT), row["information_true"].value, marker, hover))
    highest = max(row["discomfort_rate"].value for row in ranking.rows)
    ticks = [_LEAST_DISCOMFORT, 0.01, 0.1, 1.0, 10.0, 100.0]
    allowed = max(ranking.admission.discomfort_s, _LEAST_DISCOMFORT)
    axis = {
        "title": "discomfort, s per 30 s (0 is within every soft limit)",
        "type": "log",
        "range": [math.log10(_LEAST_DISCOMFORT) - 0.25, math.log10(max(highest, allowed, 1.0)) + 0.3],
        "tickvals": ticks,
        "ticktext": ["0", *(f"{tick:g}" for tick in ticks[1:])],
    }
    floor = drawing.floor(ranking)
    true = [row["information_true"].value for row in ranking.rows]
    layout: Chart = {
        "xaxis": axis,
        "yaxis": {"title": "true information, nats"},
        "height": 420,
        "shapes": [
            {"type": "line", "x0": allowed, "x1": allowed, "y0": 0, "y1": 1, "yref": "paper", "line": {"dash": "dot"}}
        ],
    }
    if min(true) < floor < max(true):
        layout["yaxis"]["range"] = [1.3 * floor, 1.1 * max(true)]
    return {"data": traces, "layout": layout, "labels": False, "places": True}


def curves(study: Results, ranking: Ranking) -> dict[str, Any]:
    """Sd of every parameter over time, entry by entry: time, and of each parameter centre, low, high and bound."""
    by_entry: dict[str, Any] = {}
    for row in ranking.rows:
        of_entry: dict[str, Any] = {}
        for parameter in study.parameters:
            table = _thin(study, row.entry, f"sd/{parameter}")
            of_entry["time"] = _plain(table["time_s"])
            names = ("centre", "low", "high", "bound") if ranking.has_bound else ("centre", "low", "high")
            of_entry[parameter] = {name: _plain(table[name]) for name in names if np.isfinite(table[name]).all()}
        by_entry[row.entry] = of_entry
    return by_entry


def sd_range(study: Results) -> list[float]:
    """Ends of the axis that all panels of sds share, powers of ten."""
    sd = study.curves[study.curves["quantity"].str.startswith("sd/")]
    return [math.log10(0.8 * float(sd["low"].min())), math.log10(1.15 * float(sd["high"].max()))]


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


def _down(ranking: Ranking, traces: list[Chart], axis: Chart) -> Chart:
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


def _over_time(traces: list[Chart], axis: Chart, height: int) -> Chart:
    """Curves over the episode's time."""
    layout = {"xaxis": {"title": "time, s"}, "yaxis": axis, "height": height, "hovermode": "closest"}
    return {"data": traces, "layout": layout, "labels": True}


def _sd_axis(title: str) -> Chart:
    """A logarithmic axis of sds, in percent."""
    ticks = {"tickvals": list(_SD_TICKS), "ticktext": [f"{100 * tick:g} %" for tick in _SD_TICKS]}
    return {"title": title, "type": "log", **ticks}


def _look(ranking: Ranking, i: int) -> Chart:
    """Colour and symbol of an entry's markers."""
    entry = entries(ranking)[i]
    return {"color": entry["colour"], "symbol": entry["symbol"]}


def _styled(ranking: Ranking, i: int, x: Array, y: Array, hover: str) -> Chart:
    """A line in the look of its entry."""
    entry = entries(ranking)[i]
    return {
        "x": _plain(x),
        "y": _plain(y),
        "mode": "lines",
        "name": entry["name"],
        "meta": i,
        "line": {"color": entry["colour"], "dash": entry["dash"], "width": entry["width"]},
        "hovertemplate": f"{entry['name']}<br>{hover}<extra></extra>",
    }


def _line(study: Results, ranking: Ranking, i: int, quantity: str, hover: str) -> Chart:
    """Centre of a quantity over time."""
    table = _thin(study, ranking.rows[i].entry, quantity)
    return _styled(ranking, i, table["time_s"], table["centre"], f"{hover} at %{{x:.1f}} s")


def _thin(study: Results, entry: str, quantity: str) -> dict[str, Array]:
    """One curve, thinned to the resolution of a panel."""
    table = study.curves[(study.curves["entry"] == entry) & (study.curves["quantity"] == quantity)]
    picked = table.iloc[np.unique(np.linspace(0, len(table) - 1, _POINTS).round().astype(int))]
    return {name: picked[name].to_numpy(dtype=np.float64) for name in ("time_s", "centre", "low", "high", "bound")}


def _point(ranking: Ranking, i: int, x: float, y: float, interval: Interval, hover: str) -> Chart:
    """A dot with its interval."""
    colour = drawing.colours(ranking)[ranking.rows[i].entry]
    point = _mark(i, x, y, {"size": 11} | _look(ranking, i), hover)
    has_ends = interval.exists and math.isfinite(interval.high)
    high, low = (max(interval.high - x, 0.0), max(x - interval.low, 0.0)) if has_ends else (0.0, 0.0)
    error = {"type": "data", "array": [high], "arrayminus": [low], "symmetric": False, "color": colour}
    return point | {"error_x": error | {"thickness": 3, "width": 0}}


def _mark(i: int, x: float, y: float, marker: Chart, hover: str) -> Chart:
    """One marker."""
    trace: Chart = {"x": _plain(np.array([x])), "y": _plain(np.array([y])), "mode": "markers", "meta": i}
    return trace | {"marker": marker, "hovertemplate": f"{hover}<extra></extra>"}


def _cloud(ranking: Ranking, i: int, values: Array, seeds: Array, unit: str) -> Chart:
    """A small dot per patient, spread across the upper part of the row so that none hides another."""
    across = i + np.random.default_rng(0).uniform(-0.36, 0.04, len(values))
    name = words.label(ranking.rows[i].entry)
    return {
        "x": _plain(values),
        "y": _plain(across),
        "mode": "markers",
        "meta": i,
        "marker": {"size": 5, "opacity": 0.45} | _look(ranking, i),
        "customdata": [int(seed) for seed in seeds],
        "hovertemplate": f"{name}<br>patient of seed %{{customdata}}: {unit}<extra></extra>",
    }


def _band(ranking: Ranking, axis: str) -> Chart:
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


def _plain(values: Array) -> list[float | None]:
    """Numbers for JSON: four significant digits, and nothing where there is none."""
    return [float(f"{value:.4g}") if math.isfinite(value) else None for value in values]
