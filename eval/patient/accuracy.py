"""Accuracy of verdicts: sensitivity, specificity and both kinds of error, muscle by muscle over a cohort."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from rich.console import Console
from rich.text import Text

from eval.comparison.results import Results
from eval.figures import statistics, words
from eval.figures.statistics import Interval
from eval.figures.tables import Table
from jawenv.metrics import Diagnosis

Mask = NDArray[np.bool_]

ALL = "all muscles"
SHARES = {
    "sensitivity": "sensitivity",
    "false_normal": "raised, called normal",
    "specificity": "specificity",
    "false_raised": "normal, called raised",
    "undecided": "not known yet",
}
NOTE = (
    "Shares in %, with 95 % intervals over patients: of Wilson for one muscle, bootstrap for all. Stiff: F_o raised; "
    "blocked: b raised. A muscle is decided when the posterior is 95 % sure. One that is not counts neither as found "
    "(sensitivity) nor as cleared (specificity). The two errors: of the muscles that are truly raised those called "
    "normal, of the truly normal those called raised. A calibrated posterior is wrong in at most 5 % of its decisions."
)


def accuracy(study: Results) -> pd.DataFrame:
    """One row per entry, property and muscle, and one for all muscles together.

    Args:
        study: results of a comparison; a patient counts with the belief at the end of the episode.

    Returns:
        Columns ``entry``, ``property`` (`stiff` or `blocked`), ``above`` (threshold of F_o, N, or of b), ``muscle``,
        ``raised`` and ``normal`` (numbers of truly such muscles), and each of ``SHARES`` with ``_low`` and ``_high``,
        the ends of its 95 % interval; NaN where there is no such muscle.
    """
    return pd.DataFrame([row for entry in study.entries for row in _rows(study, entry)])


def _rows(study: Results, entry: str) -> list[dict[str, object]]:
    muscles = [words.muscle(name) for name in study.parameters[::2]]
    rows: list[dict[str, object]] = []
    for name, (threshold, made) in study.diagnoses(entry).items():
        labels: dict[str, object] = {"entry": entry, "property": name, "above": threshold}
        rows.append(labels | {"muscle": ALL} | _figures(made, slice(None)))
        rows += [labels | {"muscle": muscle} | _figures(made, slice(i, i + 1)) for i, muscle in enumerate(muscles)]
    return rows


def _figures(made: Diagnosis, muscles: slice) -> dict[str, object]:
    """Shares over some of the muscles, with their intervals."""
    raised, up, down = (values[:, muscles] for values in (made.raised, made.called_raised, made.called_normal))
    shares = {
        "sensitivity": _share(up, raised),
        "false_normal": _share(down, raised),
        "specificity": _share(down, ~raised),
        "false_raised": _share(up, ~raised),
        "undecided": _share(~(up | down), np.ones_like(raised)),
    }
    figures: dict[str, object] = {"raised": int(raised.sum()), "normal": int((~raised).sum())}
    for name, interval in shares.items():
        figures |= interval.columns(name)
    return figures


def _share(hits: Mask, among: Mask) -> Interval:
    if hits.shape[1] == 1:
        return statistics.share(hits[among])
    return statistics.share_of_muscles(hits, among)


def cells(row: pd.Series) -> list[str]:
    """A row's figures: muscle, numbers of raised and normal ones, and every share with its interval."""
    shares = [words.scaled(Interval.of(row, name), 100.0) for name in SHARES]
    return [str(row["muscle"]), str(row["raised"]), str(row["normal"]), *map(words.with_interval, shares)]


def _heading(row: pd.Series) -> str:
    limit = f"F_o above {row['above']:g} N" if row["property"] == "stiff" else f"b above {row['above']:g}"
    return f"{words.label(row['entry'])}: {row['property']}, {limit}"


_COLUMNS = ("muscle", "raised", "normal", *SHARES.values())


def show(table: pd.DataFrame, console: Console) -> None:
    """Print the rows of all muscles together, a line per entry and property."""
    rows = [
        [words.label(row["entry"]), str(row["property"]), *cells(row)[1:]]
        for _, row in table[table["muscle"] == ALL].iterrows()
    ]
    Table(("maneuver", "property", *_COLUMNS[1:]), rows, (0, 1)).show(console)
    console.print(Text(NOTE, style="dim"))


def markdown(table: pd.DataFrame, lead: str) -> str:
    """A Markdown table per entry and property, below a line on their making."""
    parts = [lead]
    for _, rows in table.groupby(["entry", "property"], sort=False):
        parts += [
            f"## {_heading(rows.iloc[0])}",
            Table(_COLUMNS, [cells(row) for _, row in rows.iterrows()]).markdown(),
        ]
    return "\n\n".join([*parts, NOTE]) + "\n"
