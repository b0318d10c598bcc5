"""What the terminal shows while entries are played: a bar on a terminal, a plain line per entry elsewhere."""

from __future__ import annotations

import time
from collections.abc import Sequence
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from eval.entries import Entry
from eval.report import words

PLAIN_INTERVAL_S = 10.0


class StudyProgress:
    """Shows which entry is played, how far it is, and how many are left.

    Args:
        entries: what is going to be played.
        console: where to write.
    """

    def __init__(self, entries: Sequence[Entry], console: Console) -> None:
        self._number = len(entries)
        self._done = 0
        self._console = console
        self._last_line_s = time.monotonic()
        self._bar: Progress | None = None
        if console.is_terminal:
            self._bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(bar_width=32),
                TextColumn("{task.percentage:>3.0f} %"),
                TimeRemainingColumn(),
                console=console,
            )
            self._task = self._bar.add_task("starting", total=float(self._number))

    def __enter__(self) -> StudyProgress:
        """Start drawing."""
        if self._bar is not None:
            self._bar.start()
        else:
            self._console.print(f"playing {self._number} entries", soft_wrap=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop drawing."""
        if self._bar is not None:
            self._bar.stop()

    def advance(self, entry: Entry, step: int, steps: int) -> None:
        """Say how many steps of an entry are done."""
        name = words.label(entry.label)
        if self._bar is not None:
            description = f"{self._done + 1} of {self._number}  {name}"
            self._bar.update(self._task, completed=self._done + step / steps, description=description)
        elif time.monotonic() - self._last_line_s >= PLAIN_INTERVAL_S:
            self._last_line_s = time.monotonic()
            share = 100.0 * step / steps
            self._console.print(f"{self._done + 1} of {self._number}  {name}: {share:.0f} %", soft_wrap=True)

    def finished(self, entry: Entry, known: bool) -> None:
        """Say that an entry is done, now or in an earlier run."""
        self._done += 1
        self._last_line_s = time.monotonic()
        if self._bar is not None:
            self._bar.update(self._task, completed=float(self._done))
        if self._bar is None or known:
            how = "kept from an earlier run" if known else "done"
            self._console.print(f"{self._done} of {self._number}  {words.label(entry.label)}: {how}", soft_wrap=True)
