"""What the rows of a calibration say of each maneuver, filter and time; as a table of figures, printed and Markdown."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd
from rich.console import Console
from rich.table import Table
from rich.text import Text

from eval import statistics, words
from eval.calibration import nuisances
from eval.calibration.beliefs import DIVERGED, ENDED, JUDGED, SIGMAS
from eval.statistics import UNKNOWN, Interval
from eval.terminal import printed_table
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
_WITH_ENDS = ("nees_per_parameter", "claimed", "true", "gap", "rmse_over_bound")


def summarise(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per maneuver, filter and time; ``_low`` and ``_high`` are the ends of 95 % bootstrap intervals.

    Args:
        rows: of ``eval.calibration.calibrate.calibrate``.

    Returns:
        ``patients`` counts those whose belief is judged; ``ended`` and ``diverged`` those left out. An honest mean NEES
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
    known = number > 0 and np.isfinite(bound).all()
    intervals["rmse_over_bound"] = statistics.rmse_over_bound(error, bound) if known else UNKNOWN
    for key, interval in intervals.items():
        figures |= interval.columns(key)
    figures |= _bias(judged, parameters)
    low, high = nees_band(number, size) if number else (float("nan"), float("nan"))
    figures |= {"honest_low": low / size, "honest_high": high / size}
    figures |= {f"inside_{sigmas}": judged[f"inside_{sigmas}"].mean() if number else float("nan") for sigmas in SIGMAS}
    figures |= {key: int((rows["outcome"] == key).sum()) for key in (ENDED, DIVERGED)}
    return figures | nuisances.summarised(judged) | {"parameters": size}


def _bias(judged: pd.DataFrame, parameters: list[str]) -> dict[str, object]:
    """Mean z of every parameter, and of the one where it is largest, with simultaneous intervals."""
    error, sd = (judged[[f"{kind}/{name}" for name in parameters]].to_numpy() for kind in ("error", "sd"))
    found = statistics.means_together(error / sd)
    furthest = int(np.argmax([abs(each.value) for each in found])) if len(judged) else 0
    figures: dict[str, object] = {"largest_mean_z_of": parameters[furthest] if len(judged) else ""}
    figures |= found[furthest].columns("largest_mean_z")
    for name, interval in zip(parameters, found, strict=True):
        figures |= interval.columns(f"mean_z/{name}")
    return figures


def _largest_mean_z(row: pd.Series) -> str:
    """As `−0.31 (−0.45 … −0.17), F_o of masseter left`."""
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


def show(table: pd.DataFrame, console: Console, *, details: bool = False) -> None:
    """Print a summary, a table per maneuver and one of bias; red: the sds are too small, yellow: too large.

    Args:
        table: the summary.
        console: where.
        details: whether to print the nuisances too.
    """
    heads = (
        "filter",
        "time\ns",
        "n",
        "NEES / p\nhonest: 1",
        "inside 1/2/3 sd\n68/95/99.7 %",
        "claimed\nnats",
        "true\nnats",
        "claimed\n− true",
        "RMSE /\nbound",
        "ended/\ndiverged",
    )
    for entry, rows in table.groupby("entry", sort=False):
        printed = printed_table(words.label(str(entry)))
        for head in heads:
            printed.add_column(head, justify="left" if head == "filter" else "right", no_wrap=True)
        for row in _rows(rows):
            texts = cells(row)
            nees, *rest = (_two_lines(texts[i]) for i in (4, 9, 10, 11))
            nees.stylize(_colour(row))
            inside = "/".join(words.percent(row[f"inside_{sigmas}"], sigmas // 3) for sigmas in SIGMAS)
            claimed, ends = words.number(row["claimed"]), f"{texts[12]}/{texts[13]}"
            printed.add_row(*texts[1:4], nees, inside, claimed, *rest, ends)
        console.print(printed)
    console.print(_bias_table(table))
    console.print(Text(NOTE, style="dim"))
    if details and nuisances.groups_in(table):
        console.print(_nuisance_table(table))
        console.print(Text(nuisances.NOTE, style="dim"))


def _colour(row: pd.Series) -> str:
    if row["nees_per_parameter_low"] > 1.0:
        return "red"
    return "yellow" if row["nees_per_parameter_high"] < 1.0 else ""


def _two_lines(cell: str) -> Text:
    value, _, ends = cell.partition(" (")
    text = Text(value)
    text.append(f"\n{ends.rstrip(')')}", style="dim")
    return text


def _bias_table(table: pd.DataFrame) -> Table:
    """The largest mean z of every maneuver, filter and time."""
    printed = printed_table("Bias: the parameter whose mean z is furthest from 0, and is 0 if honest")
    for head in ("maneuver", "filter", "time\ns", "largest\nmean z", "parameter"):
        printed.add_column(head, justify="right" if "\n" in head else "left")
    for row in _rows(table):
        entry, name, time, *_ = cells(row)
        figure, _, parameter = _largest_mean_z(row).partition(", ")
        printed.add_row(entry, name, time, _two_lines(figure), parameter)
    return printed


def _nuisance_table(table: pd.DataFrame) -> Table:
    """What is left of the nuisances' sds, per maneuver and time, below the mean square of their errors."""
    printed = printed_table("What is known within sds: (error/sd)², 1 if honest, and % of the sd left")
    for head in nuisances.heads(table):
        printed.add_column(head.replace(" ", "\n"), justify="left" if head == "maneuver" else "right")
    for entry, time, *figures in nuisances.cells(table):
        printed.add_row(entry, time, *(f"{text.split(' ')[0]}\n{text.split(', ')[1]}" for text in figures))
    return printed


def markdown(table: pd.DataFrame, lead: str) -> str:
    """A summary as a Markdown table, below a line that says what it was made with."""
    parts = [lead, "", words.table(COLUMNS, map(cells, _rows(table)), (0, 1)), "", NOTE]
    if nuisances.groups_in(table):
        parts += ["", words.table(nuisances.heads(table), nuisances.cells(table), (0,)), "", nuisances.NOTE]
    return "\n".join(parts) + "\n"


def _rows(table: pd.DataFrame) -> Iterator[pd.Series]:
    return (row for _, row in table.iterrows())
