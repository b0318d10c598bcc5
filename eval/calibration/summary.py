"""Figures of a calibration for each maneuver, filter and time, and their tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from rich.console import Console
from rich.text import Text

from eval.calibration import nuisances, scores
from eval.figures import statistics, words
from eval.figures.statistics import UNKNOWN, Interval
from eval.figures.tables import Table
from eval.rows.beliefs import DIVERGED, ENDED, JUDGED, SIGMAS
from jawenv.metrics import nees_band

COLUMNS = (
    "maneuver",
    "filter",
    "time, s",
    "patients",
    "NEES / p",
    "honest NEES / p",
    "inside 1/2/3 sd, %",
    "largest mean z",
    "claimed, nats",
    "true, nats",
    "claimed − true",
    "RMSE / bound",
    "ended early",
    "diverged",
)
NOTE = (
    "Means over the patients, with 95 % bootstrap intervals, at times that their episodes reached. NEES / p above 1: "
    "sds too small; below: too large. Mean z: estimate minus truth over sd, of the parameter where that is furthest "
    "from 0, with an interval that holds for all parameters at once. Claimed minus true information: what the filter "
    "says it has learned beyond what the log score grants. RMSE / bound: root mean square error over that of the "
    "posterior Cramér-Rao bound, mean over the p parameters. Ended: the episode was over before that time; diverged: "
    "the filter had no belief any more."
)
_PRINTED, _BIAS = (*COLUMNS[1:5], COLUMNS[6], *COLUMNS[8:]), (*COLUMNS[:3], "largest mean z")
_WITH_ENDS = ("nees_per_parameter", "claimed", "true", "gap", "rmse_over_bound")


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


def cells(row: pd.Series) -> list[str]:
    """A row's figures in the order of ``COLUMNS``, each with its interval."""
    interval = {key: Interval.of(row, key) for key in _WITH_ENDS}
    return [
        words.label(row["entry"]),
        row["filter"],
        f"{row['time_s']:g}",
        str(row["patients"]),
        words.with_interval(interval["nees_per_parameter"], 2),
        words.interval(Interval(1.0, row["honest_low"], row["honest_high"]), 2) or words.NOTHING,
        " / ".join(words.percent(row[f"inside_{sigmas}"]) for sigmas in SIGMAS),
        _largest_mean_z(row),
        words.with_interval(interval["claimed"], 1),
        words.with_interval(interval["true"], 1),
        words.with_interval(interval["gap"], 1),
        words.with_interval(interval["rmse_over_bound"], 2),
        str(row[ENDED]),
        str(row[DIVERGED]),
    ]


def tables(table: pd.DataFrame) -> list[Table]:
    """The table of a summary, one of its scores, and one of nuisances where the filter has some.

    Args:
        table: of `summarise`.
    """
    main = Table(COLUMNS, [cells(row) for _, row in table.iterrows()], (0, 1), NOTE)
    return [main, scores.table_of(table), *([nuisances.table_of(table)] if nuisances.groups_in(table) else [])]


def show(table: pd.DataFrame, console: Console) -> None:
    """Print a summary: a table of each maneuver, and one of bias; scores and nuisances are in the file."""
    lost = {"ended early": ENDED, "diverged": DIVERGED}
    printed = [name for name in _PRINTED if name not in lost or table[lost[name]].any()]
    for entry, rows in table.groupby("entry", sort=False):
        Table(printed, _columns(rows, printed), title=words.label(str(entry))).show(console)
    Table(_BIAS, _columns(table, _BIAS), (0, 1, 3), title="Bias: the parameter with the largest mean z").show(console)
    console.print(Text(NOTE, style="dim"))


def _columns(table: pd.DataFrame, names: Sequence[str]) -> list[list[str]]:
    places = [COLUMNS.index(name) for name in names]
    return [[cells(row)[index] for index in places] for _, row in table.iterrows()]


def markdown(table: pd.DataFrame, lead: str) -> str:
    """A summary as Markdown, below a line on its making."""
    return "\n\n".join([lead, *(part.markdown() for part in tables(table))]) + "\n"
