"""Progress of a command: a bar on a terminal, a plain line every ten seconds elsewhere.

It needs rich, which the commands of `training` and `eval` bring and the library itself does not need.
"""

from __future__ import annotations

import time
from collections import deque
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

PLAIN_INTERVAL_S = 10.0
RATE_WINDOW_S = 30.0
SLOWEST_RATE = 10.0  # per second: below it a rate is harder to read than the time left
# Kernels are compiled in the first piece of work and at times in the next ones, which is no speed to go by.
WARM_UP_SHARE, WARM_UP_S = 0.05, 60.0  # after the first piece, whichever comes first
LEAST_PIECES = 3  # after that, before a time left is said


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
        self._waiting = True  # for the first piece of work
        self._restart(done)
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
        if self._waiting:
            self._restart(done)
            self._waiting = False
        else:
            self._history.append((now, done))
            self._warm_up(now)
        while now - self._history[0][0] > RATE_WINDOW_S and len(self._history) > 2:
            self._history.popleft()
        self._show(now)

    def skip(self, number: float) -> None:
        """Say that so much more was done in an earlier run, which says nothing about the speed."""
        self._restart(self._done + number)
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
        """Speed of late, time left at the speed of all so far, since some work is slower than other, and notes.

        The speed is measured from the first piece of work on, the time left from the end of the warm-up on.
        """
        parts = []
        now_s, done = self._history[-1]
        recent, whole = (_rate(since, (now_s, done)) for since in (self._history[0], self._begun))
        if recent >= SLOWEST_RATE:
            parts.append(f"{recent:,.0f} {self._unit}/s")
        if whole > 0.0 and self._pieces >= LEAST_PIECES:
            parts.append(f"{_clock((self.total - done) / whole)} left")
        return " · ".join([*parts, *self._notes.values()])

    def _restart(self, done: float) -> None:
        """Measure the speed from here on."""
        self._done = done
        self._first = self._begun = (time.monotonic(), done)
        self._waiting, self._warm, self._pieces = True, False, 0
        self._history: deque[tuple[float, float]] = deque([self._first])

    def _warm_up(self, now: float) -> None:
        """Count the pieces of work after the warm-up, at whose end the measurement of the time left begins."""
        since_s, since = self._first
        if self._warm:
            self._pieces += 1
        elif self._done - since >= WARM_UP_SHARE * self.total or now - since_s >= WARM_UP_S:
            self._warm, self._begun = True, (now, self._done)

    def _show(self, now: float) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=min(self._done, self.total), description=self.describe())
        elif now - self._last_line_s >= PLAIN_INTERVAL_S:
            figures = f"{int(self._done):,} of {self.total:,.0f} {self._unit} ({100.0 * self._done / self.total:.0f} %)"
            self.say(" · ".join(filter(None, (figures, self.describe()))))


def _rate(since: tuple[float, float], now: tuple[float, float]) -> float:
    """Units done per second between two moments (time, units done); 0 if either has not grown."""
    return (now[1] - since[1]) / (now[0] - since[0]) if now[0] > since[0] and now[1] > since[1] else 0.0


def _clock(seconds: float) -> str:
    minutes, remainder = divmod(round(max(seconds, 0.0)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{remainder:02d}" if hours else f"{minutes}:{remainder:02d}"
