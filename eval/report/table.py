"""The ranked tables in the terminal."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from eval.comparison.adaptation import Adaptation
from eval.comparison.ranking import Ranking, Row
from eval.comparison.results import EARLY_S
from eval.report import words
from eval.statistics import Interval

_COLOUR = {"honest": "green", "overconfident": "red", "cautious": "yellow"}
_MEANING = {"honest": "honest", "overconfident": "too small", "cautious": "too large"}


def show(ranking: Ranking, console: Console) -> None:
    """Print how well the parameters are known, how soon, how honestly, and at what discomfort.

    Args:
        ranking: see `eval.comparison.ranking.rank`.
        console: where to print.
    """
    for table in (_precision(ranking), _speed(ranking), _trust(ranking)):
        console.print(table)
    low, high = ranking.band
    console.print(
        Text(
            f"{ranking.patients} patients, the same for all; below a figure its 95 % bootstrap interval over them. "
            "sd is of the natural log: 5 % is 5 % of the parameter. Ranked by true information, which a filter "
            f"cannot raise by overconfidence. An honest mean NEES lies in {low:.1f} … {high:.1f}.",
            style="dim",
        )
    )


def show_adaptations(found: tuple[Adaptation, ...], console: Console) -> None:
    """Print how much better entries are than their replays; nothing where none was replayed."""
    if not found:
        return
    table = _table(
        "Against the own targets, replayed without looking: mean difference of the log of the worst sd",
        f"after {EARLY_S:g} s",
        "",
        "at the end",
        "",
    )
    for place, each in enumerate(found, 1):
        table.add_row(
            str(place),
            f"{words.label(each.entry)}\nagainst {words.label(each.replay)}",
            _both(each.early, 2),
            each.verdict(each.early),
            _both(each.end, 2),
            each.verdict(each.end),
        )
    console.print(table)


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("#", justify="right")
    table.add_column("maneuver", min_width=16)
    for column in columns:
        table.add_column(column, justify="right")
    return table


def _precision(ranking: Ranking) -> Table:
    table = _table(
        f"How well all {ranking.n_parameters} parameters of {ranking.env} are known at the end",
        "true info\nnats",
        "minus that of\nthe reference",
        "worst sd, %\nmedian",
        "\np90",
        "\nmax",
        f"NEES\nhonest: {ranking.n_parameters}",
        "so the sd\nare",
    )
    for place, row in enumerate(ranking.rows, 1):
        verdict = ranking.calibration(row)
        table.add_row(
            str(place),
            _name(row),
            _both(row.information_true),
            "reference" if row.difference is None else _both(row.difference),
            _both(words.scaled(row.worst_sd_median, 100.0)),
            words.percent(row.worst_sd_p90.value),
            words.percent(row.worst_sd_max),
            _both(row.nees),
            Text(_MEANING[verdict], style=_COLOUR[verdict]),
        )
    return table


def _speed(ranking: Ranking) -> Table:
    targets = [f"{100.0 * target:g} %" for target in ranking.rows[0].time_to]
    table = _table(
        "How soon: median time until the worst sd is within a target, and share of patients that get there",
        *(f"{target}\ns" for target in targets),
        *(f"{target}\nshare, %" for target in targets),
        f"known\nof {ranking.n_parameters}",
    )
    for place, row in enumerate(ranking.rows, 1):
        table.add_row(
            str(place),
            _name(row),
            *(words.number(time.value) for time in row.time_to.values()),
            *(words.percent(share.value, 0) for share in row.share_to.values()),
            words.number(row.identified.value),
        )
    return table


def _trust(ranking: Ranking) -> Table:
    table = _table(
        "Whether that can be believed, and what it costs the patient",
        "inside 1/2/3 sd\n68/95/99.7 %",
        "claimed − true\nnats",
        "RMSE /\nbound",
        "discomfort\ns",
        "violating\nepisodes, %",
        "governor\n%",
    )
    for place, row in enumerate(ranking.rows, 1):
        table.add_row(
            str(place),
            _name(row),
            "/".join(words.percent(inside.value, sigmas // 3) for sigmas, inside in row.inside.items()),
            _both(row.honesty_gap),
            words.number(row.rmse_over_bound.value, 2),
            words.number(row.discomfort_s.value, 2),
            words.percent(row.violated.value),
            words.percent(row.governor.value),
        )
    return table


def _name(row: Row) -> Text:
    name = Text(words.label(row.entry), style="bold magenta" if row.trained else "")
    if row.note:
        name.append(f"\n{row.note}", style="dim")
    return name


def _both(estimate: Interval, digits: int = 1) -> Text:
    text = Text(words.number(estimate.value, digits))
    text.append(f"\n{words.interval(estimate, digits)}", style="dim")
    return text
