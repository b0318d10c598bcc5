"""What the terminal shows while many draws are made: a bar on a terminal, a plain line now and then elsewhere."""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from eval.progress import PLAIN_INTERVAL_S
from eval.report import words


class DrawProgress:
    """Shows how many of all draws are made, and what is drawn.

    Args:
        draws: how many in all.
        console: where to write.
        noun: what a draw is called, in the plural.
    """

    def __init__(self, draws: int, console: Console, noun: str = "draws") -> None:
        self._draws, self._done, self._kept, self._noun = draws, 0, 0, noun
        self._console = console
        self._last_line_s = time.monotonic()
        self._bar: Progress | None = None
        if console.is_terminal:
            self._bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(bar_width=32),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
                console=console,
            )
            self._task = self._bar.add_task("starting", total=float(draws))

    def __enter__(self) -> DrawProgress:
        """Start drawing."""
        if self._bar is not None:
            self._bar.start()
        else:
            self._console.print(f"making {self._draws} {self._noun}", soft_wrap=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop drawing, and say what was there already."""
        if self._bar is not None:
            self._bar.stop()
        if self._kept:
            self._console.print(f"{self._kept} of {self._draws} {self._noun} kept from an earlier run", soft_wrap=True)

    def finished(self, key: str, number: int, known: bool) -> None:
        """Say that draws of an item are made, now or in an earlier run."""
        self._done += number
        self._kept += number if known else 0
        if self._bar is not None:
            self._bar.update(self._task, completed=float(self._done), description=words.label(key))
        elif not known and time.monotonic() - self._last_line_s >= PLAIN_INTERVAL_S:
            self._last_line_s = time.monotonic()
            self._console.print(f"{self._done} of {self._draws} {self._noun}, last {words.label(key)}", soft_wrap=True)
