"""Tables of figures: the same one in Markdown and in the terminal."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

_MEANT = re.compile(r"[&<>|`*~$\[\]{}\\]|(?<![^\W_])_|_(?![^\W_])|\s")


def plain(text: str) -> str:
    """A text, perhaps of others, in Markdown: its signs have no meaning there, nor in HTML or a table."""
    return _MEANT.sub(lambda sign: " " if sign[0].isspace() else f"&#{ord(sign[0])};", text)


def code(text: str) -> str:
    """A text, perhaps of others, as code in a line of Markdown."""
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    space = " " if len(fence) > 1 else ""
    return f"{fence}{space}{' '.join(text.split())}{space}{fence}"


class Marked(str):
    """A text of the program's own, whose Markdown is meant."""

    __slots__ = ()


@dataclass(frozen=True)
class Table:
    """Rows of written figures below their headings."""

    head: Sequence[str]  # a heading for each column
    rows: Sequence[Sequence[str]]  # a text for each column
    texts: Collection[int] = (0,)  # places of the columns that hold no figures
    note: str = ""  # remark below the table; empty for none
    title: str = ""  # above it in the terminal

    def markdown(self) -> str:
        """The table, and below it the note; texts in cells stay texts, unless they are `Marked`."""
        rule = ["---" if column in self.texts else "--:" for column in range(len(self.head))]
        lines = [
            "| " + " | ".join(cell if isinstance(cell, Marked) else plain(cell) for cell in cells) + " |"
            for cells in (self.head, *self.rows)
        ]
        lines.insert(1, "|" + "|".join(rule) + "|")
        return "\n".join([*lines, *(["", self.note] if self.note else [])])

    def show(self, console: Console, *, intervals: bool = True) -> None:
        """Print it, each interval below its figure."""
        printed = printed_table(self.title)
        rows = [[_two_lines(text, intervals) for text in row] for row in self.rows]
        for column, name in enumerate(self.head):
            lines = [line for row in rows for line in row[column].plain.splitlines()]
            if column in self.texts:
                least = max(map(len, " ".join(lines).split()), default=0)
                printed.add_column(name, min_width=least)
            else:  # a heading may break, a figure may not
                least, broken = max(map(len, lines), default=0), re.sub(r", | (?=[/−] )", "\n", name)
                printed.add_column(broken, justify="right", min_width=least)
        for row in rows:
            printed.add_row(*row)
        console.print(printed)
        if self.note:
            console.print(Text(self.note, style="dim"))


def _two_lines(text: str, intervals: bool) -> Text:
    value, _, ends = text.partition(" (")
    written = Text(value)
    if ends and intervals:
        written.append("\n" + ends.replace(")", "", 1), style="dim")
    return written


def made_by(metadata: Mapping[str, Any], what: str) -> str:
    """A sentence on the making of some tables.

    Args:
        metadata: of `eval.kept.tables.made_with`.
        what: description of the played episodes.
    """
    versions, git, machine = metadata["versions"], metadata["git"], metadata["machine"]
    state = "" if git is None else f", commit {git['commit'][:12]}" + (" with changes" if git["changed"] else "")
    return (
        f"Made by {code(metadata['command'])}, {plain(metadata['finished'])}: {what}. "
        f"jawenv {plain(versions['jawenv'])}{plain(state)}; {machine['cores']} cores of {plain(machine['processor'])}."
    )


def printed_table(title: str = "") -> RichTable:
    """A table without columns as yet, below a bold title."""
    return RichTable(title=title or None, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
