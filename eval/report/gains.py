"""What trained and planned entries gain, in the terminal and as Markdown."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.text import Text

from eval import words
from eval.comparison.trainings import FIGURES, Gain
from eval.tables import Table, printed_table
from jawenv.files import write_text

SHOWN = ("early_worst_sd", "worst_sd", "information_true", "discomfort_s")
"""The figures that a terminal has room for."""


def show(found: tuple[Gain, ...], console: Console) -> None:
    """Print the differences; nothing where there are none."""
    if not found:
        return
    table = printed_table("Trained and planned entries, patient by patient: mean differences")
    table.add_column("entry", min_width=16)
    for figure in SHOWN:
        table.add_column(FIGURES[figure].title, justify="right")
    for each in found:
        entry = Text(words.label(each.name) + (f", {each.seeds} seeds" if each.seeds > 1 else ""))
        entry.append(f"\nagainst {words.label(each.against)}", style="dim")
        table.add_row(entry, *(_both(each, figure) for figure in SHOWN))
    console.print(table)


def write(found: tuple[Gain, ...], path: Path) -> None:
    """Write all figures as a Markdown table."""
    head = ["contestant", "against", "seeds", *(figure.title for figure in FIGURES.values())]
    rows = [
        [
            words.label(each.name),
            words.label(each.against),
            str(each.seeds),
            *(words.with_interval(each.figures[name], figure.digits) for name, figure in FIGURES.items()),
        ]
        for each in found
    ]
    write_text(path, Table(head, rows, (0, 1)).markdown() + "\n")


def _both(gain: Gain, name: str) -> Text:
    estimate, digits = gain.figures[name], FIGURES[name].digits
    text = Text(words.number(estimate.value, digits))
    text.append(f"\n{words.interval(estimate, digits)}", style="dim")
    return text
