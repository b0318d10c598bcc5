"""Bounds on the expected information gain as a table, in Markdown and in the terminal."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console

from eval import words
from eval.terminal import printed_table

HEAD = (
    "design",
    "patients",
    "lower, nats",
    "upper, nats",
    "of the belief, nats",
    "claimed, nats",
    "effective contrasts",
    "ended early",
)
NOTE = (
    "Expected information gain about all parameters, mean ± standard error over the patients. Lower and upper: "
    "contrastive, with contrasts from the filter's belief (ACE and VNMC; with contrasts from the prior they would be "
    "sPCE and sNMC). Of the belief: Barber and Agakov's lower bound with the filter's belief as the posterior. "
    "Claimed: half the logarithm of the determinant of prior over posterior covariance, as the filter says it. "
    "Effective contrasts: the mean number; where it is small the upper bound is far above the gain."
)
_BOUNDS = ("lower", "upper", "posterior", "claimed")


def summarise(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per entry; ``_error`` is the standard error of the mean of that name.

    Args:
        rows: of ``eval.information.run.play``.
    """
    return pd.DataFrame([_figures(str(entry), of_entry) for entry, of_entry in rows.groupby("entry", sort=False)])


def _figures(entry: str, rows: pd.DataFrame) -> dict[str, object]:
    figures: dict[str, object] = {"entry": entry, "patients": len(rows)}
    for name in _BOUNDS:
        values = rows[name].to_numpy(dtype=np.float64)
        figures[name] = values.mean()
        figures[f"{name}_error"] = values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan
    return figures | {"effective": rows["effective"].mean(), "ended": int(rows["ended"].sum())}


def _cells(row: pd.Series) -> list[str]:
    bounds = [_with_error(row[name], row[f"{name}_error"]) for name in _BOUNDS]
    return [
        words.label(row["entry"]),
        str(row["patients"]),
        *bounds,
        words.number(row["effective"] if row["effective"] > 0.0 else float("nan")),
        str(row["ended"]),
    ]


def _with_error(value: float, error: float) -> str:
    """As `8.27 ± 0.13`."""
    return words.number(value, 2) + ("" if pd.isna(error) else f" ± {words.number(error, 2)}")


def markdown(table: pd.DataFrame, about: dict[str, Any]) -> str:
    """The page ``information.md``.

    Args:
        table: of `summarise`.
        about: of `eval.kept.tables.made_with`.
    """
    rows = [_cells(row) for _, row in table.iterrows()]
    return "\n".join([f"Made by `{about['command']}`.", "", words.table(HEAD, rows), "", NOTE, ""])


def show(table: pd.DataFrame, console: Console) -> None:
    """Print the table."""
    printed = printed_table("Expected information gain")
    for name in HEAD:
        printed.add_column(name.replace(", ", "\n"), justify="left" if name == "design" else "right")
    for _, row in table.iterrows():
        printed.add_row(*_cells(row))
    console.print(printed)
    console.print(NOTE, style="dim")
