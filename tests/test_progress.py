"""What the terminal shows during a training."""

import io

import pytest
from rich.console import Console

from training import progress as module
from training.progress import TrainingProgress


class Clock:
    now = 100.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(module, "time", clock)
    return clock


def test_plain_line_every_ten_seconds(clock: Clock) -> None:
    out = io.StringIO()
    with TrainingProgress(100_000, 20_000, Console(file=out)) as progress:
        progress.learning_return(1.5)
        progress.best_evaluation(12.25, 30_000)
        for steps in range(21_000, 51_000, 1_000):
            clock.now += 1.0
            progress.advance_to(steps)
    lines = out.getvalue().splitlines()
    assert len(lines) == 3
    assert lines[1] == (
        "40,000 of 100,000 steps (40 %) · 1,000 steps/s · 1:00 left · return 1.5 · best evaluation 12.25 at 30,000"
    )


def test_bar_on_a_terminal(clock: Clock) -> None:
    out = io.StringIO()
    with TrainingProgress(1000, 0, Console(file=out, force_terminal=True, width=140)) as progress:
        clock.now += 2.0
        progress.advance_to(500)
        progress.doing("evaluating")
    assert "500/1000" in out.getvalue() and "250 steps/s · 0:02 left · evaluating" in out.getvalue()
