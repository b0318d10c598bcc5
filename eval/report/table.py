"""The ranked tables in the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

from eval.comparison.ranking import KNOWN, Ranking, RankingRow
from eval.comparison.trainings import DIFFERENCES, Gain
from eval.figures import words
from eval.figures.catalogue import FIGURES, time_to
from eval.figures.tables import Table, printed_table
from eval.report import first

_COLOUR = {"calibrated": "green", "overconfident": "red", "cautious": "yellow"}
GAINS_SHOWN = ("early_worst_sd", "worst_sd", "information_true", "discomfort_s")
"""The figures of gains that a terminal has room for."""
_MEANING = {"calibrated": "right", "overconfident": "too small", "cautious": "too large"}


def show(ranking: Ranking, console: Console) -> None:
    """Print the best entries and all of one's own in a table."""
    console.print(_short(ranking))
    if hidden := first.rest(ranking):
        console.print(Text(f"{len(hidden)} more entries: in the report", style="dim"))


def show_verdict(ranking: Ranking, console: Console) -> None:
    """Print which entry is best, and whether that can be believed."""
    believed, because = first.belief(ranking)
    console.print(Text(first.answer(ranking), style="bold"), soft_wrap=True)
    console.print(Text(f"Can it be believed? {'Yes' if believed else 'No'}, because {because}"), soft_wrap=True)


def _short(ranking: Ranking) -> RichTable:
    columns = [
        *(_figure(time_to(target), f"within\n{100.0 * target:g} %, s") for target in (first.NEARLY_KNOWN, KNOWN)),
        _figure("verdicts_s"),
        _figure("worst_sd", "worst sd\n%", 1),
        _figure("discomfort_rate"),
        _error_bars(ranking),
    ]
    title = f"How soon {ranking.sought} are known, in half of {ranking.patients} patients"
    table = printed_table(title)
    table.add_column("#", justify="right")
    table.add_column("maneuver", min_width=16)
    for heading, _ in columns:
        table.add_column(heading, justify="right")
    for row in first.firsts(ranking):
        reason = f"not ranked: {row.excluded}" if row.excluded else ""
        table.add_row(ranking.mark(row), _name(row, reason), *(cell(row) for _, cell in columns))
    return table


Column = tuple[str, Callable[[RankingRow], str | Text]]
"""A heading, in which ``{parameters}`` stands for their number, and what stands below it."""


def _figure(name: str, heading: str = "", digits: int | None = None) -> Column:
    """A figure below a heading, or its own."""
    figure = FIGURES[name]
    return heading or figure.narrow, lambda row: figure.value(row[name], digits)


def _error_bars(ranking: Ranking) -> Column:
    def meaning(row: RankingRow) -> Text:
        kind = ranking.calibration(row)
        return Text(_MEANING[kind], style=_COLOUR[kind])

    return "error bars\nare", meaning


def _name(row: RankingRow, remark: str) -> Text:
    name = Text(words.label(row.entry), style="bold magenta" if row.trained else "")
    if remark:
        name.append(f"\n{remark}", style="dim")
    return name


def gains_table(gains: tuple[Gain, ...], figures: Iterable[str] = DIFFERENCES) -> Table:
    """Differences of trained and planned entries, an entry in a row."""
    shown = {name: DIFFERENCES[name] for name in figures}
    head = ["entry", "against", "seeds", *(figure.title for figure in shown.values())]
    rows = [
        [
            words.label(gain.name),
            words.label(gain.against),
            str(gain.seeds),
            *(words.with_interval(gain.figures[name], figure.digits) for name, figure in shown.items()),
        ]
        for gain in gains
    ]
    return Table(head, rows, (0, 1), title="Trained and planned entries, patient by patient: mean differences")
