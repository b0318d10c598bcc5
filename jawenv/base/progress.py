"""Progress of a command: a bar on a terminal, a plain line every ten seconds elsewhere.

It needs rich, which the commands of `training` and `eval` bring and the library itself does not need.
"""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

PLAIN_INTERVAL_S = 10.0
SLOWEST_RATE = 10.0  # per second: below it a rate is harder to read than the time left


class Progress:
    """Shows how much is done, how fast it goes on, how long it will take, and notes.

    Args:
        total: how much there is to do, above 0.
        unit: what is counted, in the plural.
        console: where to write.
        done: what was done before, which says nothing about the speed.

    Attributes:
        total: as given.
    """

    def __init__(self, total: float, unit: str, console: Console, done: float = 0.0) -> None:
        self.total = total
        self._unit = unit
        self._console = console
        self._notes: dict[str, str] = {}
        self._last_line_s = time.monotonic()
        self._done = done
        self._begun: tuple[float, float] | None = None  # time and work done at the end of the first piece
        self._bar: Bar | None = None
        if console.is_terminal:
            self._bar = Bar(
                BarColumn(bar_width=24),
                MofNCompleteColumn(),
                TimeElapsedColumn(),
                TextColumn("{task.description}"),
                console=console,
            )
            self._task = self._bar.add_task("starting", total=total, completed=int(done))

    def __enter__(self) -> Progress:
        """Start drawing."""
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop drawing."""
        if self._bar is not None:
            self._bar.stop()

    @property
    def done(self) -> float:
        """Amount of work done in all."""
        return self._done

    def advance_to(self, done: float, item: str = "") -> None:
        """Set how much is done in all, and the latest item."""
        now = time.monotonic()
        if item:
            self._notes["item"] = item
        self._done = done
        if self._begun is None:  # kernels are compiled in the first piece of work, which is no speed to go by
            self._begun = now, done
        self._show(now)

    def skip(self, number: float) -> None:
        """Say that so much more was done in an earlier run, which says nothing about the speed."""
        self._done += number
        self._show(time.monotonic())

    def note(self, key: str, text: str) -> None:
        """Show a text beside the figures, in place of the one before with this key; none where it is empty."""
        if text:
            self._notes[key] = text
        else:
            self._notes.pop(key, None)
        self._show(time.monotonic())

    def say(self, text: str) -> None:
        """Print a line that stays."""
        self._last_line_s = time.monotonic()
        self._console.print(text, soft_wrap=True)

    def describe(self) -> str:
        """Speed and time left, measured from the end of the first piece of work on, and notes."""
        parts = []
        since_s, since = self._begun or (0.0, self._done)
        if self._done > since:
            rate = (self._done - since) / max(time.monotonic() - since_s, 1e-9)
            parts += [f"{rate:,.0f} {self._unit}/s"] if rate >= SLOWEST_RATE else []
            parts.append(f"{_clock((self.total - self._done) / rate)} left")
        return " · ".join([*parts, *self._notes.values()])

    def _show(self, now: float) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=min(self._done, self.total), description=self.describe())
        elif now - self._last_line_s >= PLAIN_INTERVAL_S:
            figures = f"{int(self._done):,} of {self.total:,.0f} {self._unit} ({100.0 * self._done / self.total:.0f} %)"
            self.say(" · ".join(filter(None, (figures, self.describe()))))


def _clock(seconds: float) -> str:
    minutes, remainder = divmod(round(max(seconds, 0.0)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{remainder:02d}" if hours else f"{minutes}:{remainder:02d}"
