"""The ranked tables in the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from eval.comparison.ranking import KNOWN, SOON, Ranking, RankingRow
from eval.comparison.trainings import DIFFERENCES, Gain, verdict
from eval.figures import words
from eval.figures.catalogue import DIFFERENCE, FIGURES, SIGMAS, reaches, time_to
from eval.figures.statistics import Interval
from eval.figures.tables import Table as WrittenTable
from eval.figures.tables import printed_table
from eval.report import first
from eval.report.learned import Learned
from eval.rows.outcomes import EARLY_S
from jawenv.base.files import write_text
from jawenv.metrics import TARGETS

_COLOUR = {"calibrated": "green", "overconfident": "red", "cautious": "yellow"}
GAINS_SHOWN = ("early_worst_sd", "worst_sd", "information_true", "discomfort_s")
"""The figures of gains that a terminal has room for."""
_MEANING = {"calibrated": "right", "overconfident": "too small", "cautious": "too large"}


def show(ranking: Ranking, console: Console, *, details: bool = False) -> None:
    """Print the best entries in one short table; in detail all of them with honesty and discomfort.

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


def show_adaptations(adaptations: tuple[Gain, ...], console: Console) -> None:
    """Print how much better entries are than their replays; nothing where none was replayed."""
    if not adaptations:
        return
    table = _below(
        "Does it adapt? The log of the worst sd less that of its own targets, replayed without looking",
        (f"after {EARLY_S:g} s", "verdict", "at the end", "verdict"),
    )
    for number, adaptation in enumerate(adaptations, 1):
        early, end = (adaptation.figures[name] for name in ("early_worst_sd", "worst_sd"))
        name = f"{words.label(adaptation.name)}\nagainst {words.label(adaptation.against)}"
        table.add_row(str(number), name, _both(early, 2), verdict(early), _both(end, 2), verdict(end))
    console.print(table)


def _below(title: str, headings: Iterable[str]) -> Table:
    """A table of maneuvers without rows as yet."""
    table = printed_table(title)
    table.add_column("#", justify="right")
    table.add_column("maneuver", min_width=16)
    for heading in headings:
        table.add_column(heading, justify="right")
    return table


def _table(ranking: Ranking, title: str, columns: Sequence[Column]) -> Table:
    """All rows, with a line between ranked ones and the others."""
    table = _below(title, (heading.format(parameters=ranking.n_parameters) for heading, _ in columns))
    for row in ranking.rows:
        if ranking.others and row is ranking.others[0] and ranking.ranked:
            table.add_section()
        table.add_row(ranking.mark(row), _name(row, row.note), *(cell(row) for _, cell in columns))
    return table


def _short(ranking: Ranking) -> Table:
    columns = [
        *(_figure(time_to(target), f"within\n{100.0 * target:g} %, s") for target in (first.NEARLY_KNOWN, KNOWN)),
        _figure("verdicts_s"),
        _figure("worst_sd", "worst sd\n%", 1),
        _figure("discomfort_rate"),
        _error_bars(ranking),
    ]
    title = f"How soon {ranking.sought} are known, in half of {ranking.patients} patients"
    table = _below(title, (heading for heading, _ in columns))
    for row in first.firsts(ranking):
        reason = f"not ranked: {row.excluded}" if row.excluded else ""
        table.add_row(ranking.mark(row), _name(row, reason), *(cell(row) for _, cell in columns))
    return table


def _speed(ranking: Ranking) -> Table:
    columns: list[Column] = []
    for target in TARGETS:
        known, heading = target == KNOWN, f"{100.0 * target:g} %, s\nmedian"
        columns.append(_figure(time_to(target), heading, ends=known))
        columns += [_figure(f"{SOON}_p90", "\np90")] if known else []
        columns.append(_figure(reaches(target), "share\n%", 0))
    title = "Ranking: how soon all are known, as the time until the worst sd is within a target"
    return _table(ranking, title, [*columns, _figure("identified")])


def _precision(ranking: Ranking) -> Table:
    columns = [
        _figure("information_true", "true info\nnats", ends=True),
        ("minus that of\nthe reference", _against),
        _figure("worst_sd", "worst sd, %\nmedian", 1, ends=True),
        _figure("worst_sd_p90", "\np90", 1),
        _figure("worst_sd_max", "\nmax", 1),
        _figure("nees", ends=True),
        _error_bars(ranking),
    ]
    return _table(ranking, f"How well {ranking.sought} of {ranking.env} are known at the end", columns)


def _trust(ranking: Ranking) -> Table:
    columns = [
        ("inside 1/2/3 sd\n68/95/99.7 %", _inside),
        _figure("honesty_gap", "claimed − true\nnats", ends=True),
        _figure("rmse_over_bound"),
        ("discomfort\ns, % above", _discomfort),
        *map(_figure, ("violated", "rings", "governor")),
    ]
    return _table(ranking, "Whether that can be believed, and what it costs the patient", columns)


Column = tuple[str, Callable[[RankingRow], str | Text]]
"""A heading, in which ``{parameters}`` stands for their number, and what stands below it."""


def _figure(name: str, heading: str = "", digits: int | None = None, *, ends: bool = False) -> Column:
    """A figure below a heading, or its own, with the ends of its interval or without."""
    figure = FIGURES[name]
    shown = figure.digits if digits is None else digits

    def cell(row: RankingRow) -> str | Text:
        return _both(figure.scaled(row[name]), shown) if ends else figure.value(row[name], shown)

    return heading or figure.narrow, cell


def _error_bars(ranking: Ranking) -> Column:
    def meaning(row: RankingRow) -> Text:
        kind = ranking.calibration(row)
        return Text(_MEANING[kind], style=_COLOUR[kind])

    return "error bars\nare", meaning


def _against(row: RankingRow) -> str | Text:
    return _both(row[DIFFERENCE]) if DIFFERENCE in row.figures else "reference"


def _inside(row: RankingRow) -> str:
    shares = {sigmas: f"inside_{sigmas}_sigma" for sigmas in SIGMAS}
    return "/".join(FIGURES[name].value(row[name], sigmas // 3) for sigmas, name in shares.items())


def _discomfort(row: RankingRow) -> str:
    mean, above = (FIGURES[name].value(row[name], digits) for name, digits in (("discomfort_s", 2), ("above_limit", 1)))
    return f"{mean}\n{above} %"


def _name(row: RankingRow, remark: str) -> Text:
    name = Text(words.label(row.entry), style="bold magenta" if row.trained else "")
    if remark:
        name.append(f"\n{remark}", style="dim")
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
        table.add_column(DIFFERENCES[figure].title, justify="right")
    for gain in gains:
        entry = Text(words.label(gain.name) + (f", {gain.seeds} seeds" if gain.seeds > 1 else ""))
        entry.append(f"\nagainst {words.label(gain.against)}", style="dim")
        table.add_row(entry, *(_both(gain.figures[name], DIFFERENCES[name].digits) for name in GAINS_SHOWN))
    console.print(table)


def write_gains(gains: tuple[Gain, ...], path: Path) -> None:
    """Write all figures as a Markdown table."""
    head = ["contestant", "against", "seeds", *(figure.title for figure in DIFFERENCES.values())]
    rows = [
        [
            words.label(gain.name),
            words.label(gain.against),
            str(gain.seeds),
            *(words.with_interval(gain.figures[name], figure.digits) for name, figure in DIFFERENCES.items()),
        ]
        for gain in gains
    ]
    write_text(path, WrittenTable(head, rows, (0, 1)).markdown() + "\n")
