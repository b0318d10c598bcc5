"""What a training shows: a bar on a terminal, a plain line every ten seconds elsewhere."""

from __future__ import annotations

import time
from collections import deque
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

PLAIN_INTERVAL_S = 10.0
RATE_WINDOW_S = 30.0


class TrainingProgress:
    """Shows steps done, steps per second, time left, return while learning and best evaluation so far.

    Args:
        total: steps at which the training ends.
        done: steps already done when it starts (a resumed run).
        console: where to write.
    """

    def __init__(self, total: int, done: int, console: Console) -> None:
        self._total = total
        self._done = done
        self._console = console
        self._history: deque[tuple[float, int]] = deque([(time.monotonic(), done)])
        self._last_line_s = time.monotonic()
        self._activity = ""
        self._return: float | None = None
        self._best: tuple[float, int] | None = None
        self._bar: Progress | None = None
        if console.is_terminal:
            self._bar = Progress(
                BarColumn(bar_width=24),
                MofNCompleteColumn(),
                TextColumn("{task.description}"),
                console=console,
            )
            self._task = self._bar.add_task("starting", total=total, completed=done)

    def __enter__(self) -> TrainingProgress:
        """Start drawing."""
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Draw the last state and stop."""
        if self._bar is not None:
            self._bar.stop()

    def advance_to(self, steps: int) -> None:
        """Say how many steps are done."""
        now = time.monotonic()
        self._done = steps
        self._history.append((now, steps))
        while now - self._history[0][0] > RATE_WINDOW_S and len(self._history) > 2:
            self._history.popleft()
        self._show(now)

    def doing(self, activity: str) -> None:
        """Name what goes on beside learning (an evaluation); empty when learning goes on."""
        self._activity = activity
        self._show(time.monotonic())

    def learning_return(self, value: float) -> None:
        """Say the mean return of the latest training episodes."""
        self._return = value

    def best_evaluation(self, value: float, steps: int) -> None:
        """Say the best mean return on the validation cohort, and after how many steps it was reached."""
        self._best = (value, steps)

    def describe(self) -> str:
        """The figures, in one line."""
        parts = []
        span_s = self._history[-1][0] - self._history[0][0]
        if span_s > 0.0:
            rate = (self._history[-1][1] - self._history[0][1]) / span_s
            parts.append(f"{rate:,.0f} steps/s")
            if rate > 0.0:
                parts.append(f"{_clock((self._total - self._done) / rate)} left")
        if self._return is not None:
            parts.append(f"return {self._return:.4g}")
        if self._best is not None:
            parts.append(f"best evaluation {self._best[0]:.4g} at {self._best[1]:,}")
        if self._activity:
            parts.append(self._activity)
        return " · ".join(parts)

    def _show(self, now: float) -> None:
        if self._bar is not None:
            self._bar.update(self._task, completed=min(self._done, self._total), description=self.describe())
        elif now - self._last_line_s >= PLAIN_INTERVAL_S:
            self._last_line_s = now
            share = 100.0 * self._done / self._total
            self._console.print(
                f"{self._done:,} of {self._total:,} steps ({share:.0f} %) · {self.describe()}", soft_wrap=True
            )


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(max(seconds, 0.0)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
