"""The ranked tables in the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from eval.comparison.ranking import KNOWN, Ranking, RankingRow
from eval.comparison.trainings import FIGURES, Adaptation, Gain
from eval.figures import words
from eval.figures.statistics import Interval
from eval.figures.tables import Table as WrittenTable
from eval.figures.tables import printed_table
from eval.report import first
from eval.report.learned import Learned
from eval.rows.outcomes import EARLY_S
from jawenv.files import write_text

_COLOUR = {"calibrated": "green", "overconfident": "red", "cautious": "yellow"}
GAINS_SHOWN = ("early_worst_sd", "worst_sd", "information_true", "discomfort_s")
"""The figures of gains that a terminal has room for."""
_MEANING = {"calibrated": "right", "overconfident": "too small", "cautious": "too large"}


def show(ranking: Ranking, console: Console, *, details: bool = False) -> None:
    """Print the best entries in one short table; in detail all of them, how honestly, and at what discomfort.

    Args:
        ranking: see `eval.comparison.ranking.rank`.
        console: where to print.
        details: whether to print all tables of all entries.
    """
    if details:
        _show_all(ranking, console)
        return
    console.print(_short(ranking))
    if hidden := first.rest(ranking):
        console.print(Text(f"{len(hidden)} more entries, and more about each: --details", style="dim"))


def show_verdict(ranking: Ranking, learnt: Sequence[Learned], console: Console) -> None:
    """Print which entry is best, whether that can be believed, and the effect of trainings."""
    believed, because = first.belief(ranking)
    console.print(Text(first.answer(ranking), style="bold"), soft_wrap=True)
    console.print(Text(f"Can it be believed? {'Yes' if believed else 'No'}, because {because}"), soft_wrap=True)
    for lesson in learnt:
        console.print(Text(f"What was learned? {lesson.sooner}"), soft_wrap=True)


def _show_all(ranking: Ranking, console: Console) -> None:
    console.print(Text(first.answer(ranking)))
    for table in (_speed(ranking), _precision(ranking), _trust(ranking)):
        console.print(table)
    for row in ranking.others:
        console.print(Text(f"{ranking.mark(row)}  {words.label(row.entry)} is not ranked: {row.excluded}."))
    low, high = ranking.band
    console.print(
        Text(
            f"{ranking.patients} patients, the same for all; below a figure its 95 % bootstrap interval over them. "
            "sd is of the natural log: 5 % is 5 % of the parameter. Ranked by the time until all are within "
            f"{100 * KNOWN:g} % (median, then 90 % quantile, then share), then by true information. In 19 of 20 "
            f"calibrated studies of this size every mean NEES lies in {low:.1f} … {high:.1f}.",
            style="dim",
        )
    )


def show_adaptations(adaptations: tuple[Adaptation, ...], console: Console) -> None:
    """Print how much better entries are than their replays; nothing where none was replayed."""
    if not adaptations:
        return
    table = _table(
        "Does it adapt? The log of the worst sd less that of its own targets, replayed without looking",
        f"after {EARLY_S:g} s",
        "verdict",
        "at the end",
        "verdict",
    )
    for number, adaptation in enumerate(adaptations, 1):
        table.add_row(
            str(number),
            f"{words.label(adaptation.entry)}\nagainst {words.label(adaptation.replay)}",
            _both(adaptation.early, 2),
            adaptation.verdict(adaptation.early),
            _both(adaptation.end, 2),
            adaptation.verdict(adaptation.end),
        )
    console.print(table)


def _table(title: str, *columns: str) -> Table:
    table = printed_table(title)
    table.add_column("#", justify="right")
    table.add_column("maneuver", min_width=16)
    for column in columns:
        table.add_column(column, justify="right")
    return table


def _precision(ranking: Ranking) -> Table:
    table = _table(
        f"How well {ranking.sought} of {ranking.env} are known at the end",
        "true info\nnats",
        "minus that of\nthe reference",
        "worst sd, %\nmedian",
        "\np90",
        "\nmax",
        f"NEES\ncalibrated: {ranking.n_parameters}",
        "error bars\nare",
    )
    for row in _rows(ranking, table):
        kind = ranking.calibration(row)
        table.add_row(
            ranking.mark(row),
            _name(row),
            _both(row.information_true),
            "reference" if row.difference is None else _both(row.difference),
            _both(words.scaled(row.worst_sd_median, 100.0)),
            words.percent(row.worst_sd_p90.value),
            words.percent(row.worst_sd_max),
            _both(row.nees),
            Text(_MEANING[kind], style=_COLOUR[kind]),
        )
    return table


def _short(ranking: Ranking) -> Table:
    table = _table(
        f"How soon {ranking.sought} are known, in half of {ranking.patients} patients",
        *(f"within\n{100.0 * target:g} %, s" for target in (first.NEARLY_KNOWN, KNOWN)),
        "worst sd\n%",
        "discomfort\ns per 30 s",
        "error bars\nare",
    )
    for row in first.firsts(ranking):
        kind = ranking.calibration(row)
        name = Text(words.label(row.entry), style="bold magenta" if row.trained else "")
        if row.excluded:
            name.append(f"\nnot ranked: {row.excluded}", style="dim")
        table.add_row(
            ranking.mark(row),
            name,
            *(_time_to(row, target) for target in (first.NEARLY_KNOWN, KNOWN)),
            words.percent(row.worst_sd_median.value),
            words.number(row.discomfort_rate, 2),
            Text(_MEANING[kind], style=_COLOUR[kind]),
        )
    return table


def _time_to(row: RankingRow, target: float) -> str:
    return words.number(row.time_to[target].value) if target in row.time_to else words.NOTHING


def _speed(ranking: Ranking) -> Table:
    targets = list(ranking.rows[0].time_to)
    columns = [
        column
        for target in targets
        for column in (f"{100.0 * target:g} %, s\nmedian", "\np90", "share\n%")
        if target == KNOWN or not column.startswith("\n")
    ]
    table = _table(
        "Ranking: how soon all are known, as the time until the worst sd is within a target",
        *columns,
        f"known\nof {ranking.n_parameters}",
    )
    for row in _rows(ranking, table):
        figures: list[str | Text] = []
        for target in targets:
            figures.append(_both(row.time_to[target]) if target == KNOWN else words.number(row.time_to[target].value))
            figures += [words.number(row.time_to_p90[target].value)] if target == KNOWN else []
            figures.append(words.percent(row.share_to[target].value, 0))
        table.add_row(ranking.mark(row), _name(row), *figures, words.number(row.identified.value))
    return table


def _rows(ranking: Ranking, table: Table) -> Iterator[RankingRow]:
    """All rows, with a line in the table above the first that is not ranked."""
    for row in ranking.rows:
        if ranking.others and row is ranking.others[0] and ranking.ranked:
            table.add_section()
        yield row


def _trust(ranking: Ranking) -> Table:
    table = _table(
        "Whether that can be believed, and what it costs the patient",
        "inside 1/2/3 sd\n68/95/99.7 %",
        "claimed − true\nnats",
        "RMSE /\nbound",
        "discomfort\ns, % above",
        "violating\nepisodes, %",
        "alarm\nrings, %",
        "governor\n%",
    )
    for row in _rows(ranking, table):
        table.add_row(
            ranking.mark(row),
            _name(row),
            "/".join(words.percent(inside.value, sigmas // 3) for sigmas, inside in row.inside.items()),
            _both(row.honesty_gap),
            words.number(row.rmse_over_bound.value, 2),
            f"{words.number(row.discomfort_s.value, 2)}\n{words.percent(row.above_limit.value)} %",
            words.percent(row.violated.value),
            words.percent(row.rings.value),
            words.percent(row.governor.value),
        )
    return table


def _name(row: RankingRow) -> Text:
    name = Text(words.label(row.entry), style="bold magenta" if row.trained else "")
    if row.note:
        name.append(f"\n{row.note}", style="dim")
    return name


def _both(estimate: Interval, digits: int = 1) -> Text:
    text = Text(words.number(estimate.value, digits))
    text.append(f"\n{words.interval(estimate, digits)}", style="dim")
    return text


def show_gains(gains: tuple[Gain, ...], console: Console) -> None:
    """Print the differences; nothing where there are none."""
    if not gains:
        return
    table = printed_table("Trained and planned entries, patient by patient: mean differences")
    table.add_column("entry", min_width=16)
    for figure in GAINS_SHOWN:
        table.add_column(FIGURES[figure].title, justify="right")
    for gain in gains:
        entry = Text(words.label(gain.name) + (f", {gain.seeds} seeds" if gain.seeds > 1 else ""))
        entry.append(f"\nagainst {words.label(gain.against)}", style="dim")
        table.add_row(entry, *(_both(gain.figures[name], FIGURES[name].digits) for name in GAINS_SHOWN))
    console.print(table)


def write_gains(gains: tuple[Gain, ...], path: Path) -> None:
    """Write all figures as a Markdown table."""
    head = ["contestant", "against", "seeds", *(figure.title for figure in FIGURES.values())]
    rows = [
        [
            words.label(gain.name),
            words.label(gain.against),
            str(gain.seeds),
            *(words.with_interval(gain.figures[name], figure.digits) for name, figure in FIGURES.items()),
        ]
        for gain in gains
    ]
    write_text(path, WrittenTable(head, rows, (0, 1)).markdown() + "\n")
