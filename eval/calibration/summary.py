"""Figures of a calibration for each maneuver, filter and time, and their tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console
from rich.text import Text

from eval.calibration import nuisances, scores
from eval.figures import statistics, words
from eval.figures.statistics import UNKNOWN, Interval
from eval.figures.tables import Table
from eval.rows.beliefs import DIVERGED, ENDED, JUDGED, SIGMAS
from eval.rows.nuisances import LEFT
from jawenv.metrics import nees_band

NOTE = (
    "Means over the patients, with 95 % bootstrap intervals, at times that their episodes reached. NEES / p above 1: "
    "sds too small; below: too large. Mean z: estimate minus truth over sd, of the parameter where that is furthest "
    "from 0, with an interval that holds for all parameters at once. Claimed minus true information: what the filter "
    "says it has learned beyond what the log score grants. RMSE / bound: root mean square error over that of the "
    "posterior Cramér-Rao bound, mean over the p parameters. Ended: the episode was over before that time; diverged: "
    "the filter had no belief any more."
)

Columns = Mapping[str, Callable[[pd.Series], str]]


def summarise(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per maneuver, filter and time; ``_low`` and ``_high`` are the ends of 95 % bootstrap intervals.

    Args:
        rows: of `eval.kept.cells.play_cells`, with levels ``entry`` and ``filter``.

    Returns:
        ``patients`` counts the judged beliefs; ``ended`` and ``diverged`` those left out. An honest mean NEES
        per parameter lies in ``honest_low`` to ``honest_high`` with 95 %. ``mean_z/<parameter>`` is the mean of
        estimate minus truth over sd, with intervals that hold for all parameters at once; ``largest_mean_z`` that of
        ``largest_mean_z_of``.
    """
    groups = rows.groupby(["entry", "filter", "time_s"], sort=False)
    return pd.DataFrame([_figures(group) for _, group in groups])


def _figures(rows: pd.DataFrame) -> dict[str, object]:
    """The figures of one maneuver, filter and time, which all ``rows`` have in common."""
    judged = rows[rows["outcome"] == JUDGED]
    parameters = [column.removeprefix("sd/") for column in map(str, rows) if column.startswith("sd/")]
    size, number = len(parameters), len(judged)
    figures: dict[str, object] = {key: rows[key].iloc[0] for key in ("entry", "filter", "time_s")}
    figures["patients"] = number
    values = {
        "nees_per_parameter": judged["nees"] / size,
        "claimed": judged["claimed"],
        "true": judged["true"],
        "gap": judged["claimed"] - judged["true"],
    }
    intervals = {key: statistics.mean(column.to_numpy()) if number else UNKNOWN for key, column in values.items()}
    error, bound = (judged[[f"{kind}/{name}" for name in parameters]].to_numpy() for kind in ("error", "bound_sd"))
    bounded = number > 0 and np.isfinite(bound).all()
    intervals["rmse_over_bound"] = statistics.rmse_over_bound(error, bound) if bounded else UNKNOWN
    for key, interval in intervals.items():
        figures |= interval.columns(key)
    figures |= _bias(judged, parameters)
    low, high = nees_band(number, size) if number else (float("nan"), float("nan"))
    figures |= {"honest_low": low / size, "honest_high": high / size}
    figures |= {f"inside_{sigmas}": judged[f"inside_{sigmas}"].mean() if number else float("nan") for sigmas in SIGMAS}
    figures |= {key: int((rows["outcome"] == key).sum()) for key in (ENDED, DIVERGED)}
    return figures | scores.summarised(judged, parameters) | nuisances.summarised(judged) | {"parameters": size}


def _bias(judged: pd.DataFrame, parameters: list[str]) -> dict[str, object]:
    """Mean z of every parameter, and of the one where it is largest, with simultaneous intervals."""
    error, sd = (judged[[f"{kind}/{name}" for name in parameters]].to_numpy() for kind in ("error", "sd"))
    means = statistics.means_together(error / sd)
    furthest = int(np.argmax([abs(mean.value) for mean in means])) if len(judged) else 0
    figures: dict[str, object] = {"largest_mean_z_of": parameters[furthest] if len(judged) else ""}
    figures |= means[furthest].columns("largest_mean_z")
    for name, interval in zip(parameters, means, strict=True):
        figures |= interval.columns(f"mean_z/{name}")
    return figures


def _largest_mean_z(row: pd.Series) -> str:
    """A cell such as `−0.31 (−0.45 … −0.17), F_o of masseter left`."""
    if not row["largest_mean_z_of"]:
        return words.NOTHING
    symbol = row["largest_mean_z_of"].split("/", 1)[0].removeprefix("log_")
    of = f"{symbol} of {words.muscle(row['largest_mean_z_of'])}"
    return f"{words.with_interval(Interval.of(row, 'largest_mean_z'), 2)}, {of}"


def _interval(row: pd.Series, name: str, digits: int) -> str:
    return words.with_interval(Interval.of(row, name), digits)


LEVELS: Columns = {
    "maneuver": lambda row: words.label(row["entry"]),
    "filter": lambda row: str(row["filter"]),
    "time, s": lambda row: f"{row['time_s']:g}",
}
LARGEST_MEAN_Z: Columns = {"largest mean z": _largest_mean_z}
COLUMNS: Columns = {
    **LEVELS,
    "patients": lambda row: str(row["patients"]),
    "NEES / p": partial(_interval, name="nees_per_parameter", digits=2),
    "honest NEES / p": lambda row: (
        words.interval(Interval(1.0, row["honest_low"], row["honest_high"]), 2) or words.NOTHING
    ),
    "inside 1/2/3 sd, %": lambda row: " / ".join(words.percent(row[f"inside_{sigmas}"]) for sigmas in SIGMAS),
    **LARGEST_MEAN_Z,
    "claimed, nats": partial(_interval, name="claimed", digits=1),
    "true, nats": partial(_interval, name="true", digits=1),
    "claimed − true": partial(_interval, name="gap", digits=1),
    "RMSE / bound": partial(_interval, name="rmse_over_bound", digits=2),
    "ended early": lambda row: str(row[ENDED]),
    "diverged": lambda row: str(row[DIVERGED]),
}
"""Texts of a summary's row by their headings, each figure with its interval."""
_NOT_PRINTED = ("maneuver", "honest NEES / p", "largest mean z")


def _table(frame: pd.DataFrame, columns: Columns, **more: Any) -> Table:
    """A table with a row for each of a frame."""
    return Table([*columns], [[text(row) for text in columns.values()] for _, row in frame.iterrows()], **more)


def tables(table: pd.DataFrame) -> list[Table]:
    """The table of a summary, one of its scores, and one of nuisances where the filter has some.

    Args:
        table: of `summarise`.
    """
    found = [
        _table(table, COLUMNS, texts=(0, 1), note=NOTE),
        _table(table, {**LEVELS, **scores.COLUMNS}, texts=(0, 1), note=scores.NOTE),
    ]
    if of_groups := nuisances.columns_of(table):
        some = table[table[[f"{LEFT}/{group}" for group in of_groups]].notna().any(axis=1)]
        own = {name: text for name, text in LEVELS.items() if name != "filter"}
        found.append(_table(some, {**own, **of_groups}, note=nuisances.NOTE))
    return found


def show(table: pd.DataFrame, console: Console) -> None:
    """Print a summary: a table of each maneuver, and one of bias; scores and nuisances are in the file."""
    empty = [name for name, column in (("ended early", ENDED), ("diverged", DIVERGED)) if not table[column].any()]
    printed = {name: text for name, text in COLUMNS.items() if name not in (*_NOT_PRINTED, *empty)}
    for entry, rows in table.groupby("entry", sort=False):
        _table(rows, printed, title=words.label(str(entry))).show(console)
    bias = "Bias: the parameter with the largest mean z"
    _table(table, {**LEVELS, **LARGEST_MEAN_Z}, texts=(0, 1, 3), title=bias).show(console)
    console.print(Text(NOTE, style="dim"))


def markdown(table: pd.DataFrame, lead: str) -> str:
    """A summary as Markdown, below a line on its making."""
    return "\n\n".join([lead, *(part.markdown() for part in tables(table))]) + "\n"
