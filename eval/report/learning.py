"""Learning curves of trained entries, as plotly's traces and axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from agents.evaluations import CURVES
from agents.evaluations import Table as Evaluations
from eval.comparison.ranking import Ranking
from eval.report.charts import Chart, entries


def learning_charts(ranking: Ranking, tables: Mapping[int, Evaluations]) -> dict[str, Chart]:
    """A chart of each of ``agents.evaluations.CURVES`` over steps.

    Args:
        ranking: of the study.
        tables: evaluations by the number of the row.
    """
    looks = entries(ranking)
    drawn: dict[str, Chart] = {}
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
        drawn[f"learning_{column}"] = {"data": traces, "layout": layout, "labels": True}
    return drawn


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
