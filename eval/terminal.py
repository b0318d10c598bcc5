"""What was typed, and where commands write."""

from __future__ import annotations

import os
import shlex
import sys

from rich import box
from rich.console import Console
from rich.table import Table


class _Terminal(Console):
    """A console that goes on in silence when its reader has left, as ``head`` does: the results are still written."""

    def on_broken_pipe(self) -> None:
        """See rich."""
        self.quiet = True
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def terminal() -> Console:
    """A terminal of its own width, or a log wide enough for the tables."""
    return _Terminal(highlight=False, width=None if sys.stdout.isatty() else 120)


def typed() -> str:
    """The command as it was given, for the results."""
    return shlex.join(["python", "-m", "eval", *sys.argv[1:]])


def printed_table(title: str = "") -> Table:
    """A table without columns as yet, below a bold title."""
    return Table(title=title or None, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
