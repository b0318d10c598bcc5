"""Learning curves of the trained entries: what their runs' ``evaluations.csv`` holds, as charts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from agents.evaluations import CURVES, read_evaluations
from eval.comparison.ranking import Ranking
from eval.comparison.results import Results
from eval.report import charts
from jawenv.errors import InputError


def learning_charts(study: Results, ranking: Ranking) -> tuple[dict[str, charts.Chart], list[str]]:
    """A chart of each of ``agents.evaluations.CURVES`` over steps, and what could not be read of the runs."""
    trained = [each for each in study.about.get("entries", []) if each.get("trained")]
    if not trained:
        return {}, []
    tables, notes = _tables({each["label"]: each["spec"] for each in trained}, ranking)
    looks = charts.entries(ranking)
    found = {}
    for column, label, factor in CURVES if tables else ():
        traces = []
        for i, table in tables.items():
            rows = [row for row in table if column in row]
            traces.append(
                {
                    "x": [row["steps"] for row in rows],
                    "y": [factor * row[column] for row in rows],
                    "mode": "lines+markers",
                    "name": looks[i]["name"],
                    "meta": i,
                    "line": {"color": looks[i]["colour"], "dash": looks[i]["dash"], "width": 2},
                    "error_y": _errors(rows, column, factor, looks[i]["colour"]),
                    "hovertemplate": f"{looks[i]['name']}<br>%{{y:.3g}} after %{{x:,}} steps<extra></extra>",
                }
            )
        layout = {
            "xaxis": {"title": "environment steps"},
            "yaxis": {"title": label, "rangemode": "tozero"},
            "height": 300,
            "hovermode": "closest",
        }
        found[f"learning_{column}"] = {"data": traces, "layout": layout, "labels": True}
    return found, notes


def _errors(rows: list[dict[str, float]], column: str, factor: float, colour: str) -> dict[str, Any]:
    """Bars of the interval of each evaluation, where the run kept it."""
    low, high = f"{column}_low", f"{column}_high"
    if not all({low, high} <= set(row) for row in rows):
        return {"visible": False}
    return {
        "type": "data",
        "symmetric": False,
        "array": [factor * (row[high] - row[column]) for row in rows],
        "arrayminus": [factor * (row[column] - row[low]) for row in rows],
        "color": colour,
        "thickness": 1,
        "width": 3,
    }


def _tables(specs: dict[str, str], ranking: Ranking) -> tuple[dict[int, list[dict[str, float]]], list[str]]:
    """Evaluations by the number of the row, of the runs that are still where they were."""
    found, notes = {}, []
    for i, row in enumerate(ranking.rows):
        if row.entry not in specs or not Path(specs[row.entry]).is_dir():
            continue
        try:
            table = read_evaluations(Path(specs[row.entry]))
        except InputError as error:
            notes.append(str(error))
            continue
        if table:
            found[i] = table
    return found, notes
