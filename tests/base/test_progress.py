"""What the terminal shows while a command works."""

import io

import pytest
from rich.console import Console

from jawenv.base import progress as module
from jawenv.base.progress import Progress


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
    with Progress(100_000, "steps", Console(file=out), 20_000) as progress:
        progress.note("return", "return 1.5")
        progress.note("best", "best evaluation 12.25 at 30,000")
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
    with Progress(1000, "steps", Console(file=out, force_terminal=True, width=140)) as progress:
        for done in (0, 100, 200, 300, 400):
            progress.advance_to(done)
            clock.now += 0.5
        progress.advance_to(500)
        progress.note("activity", "evaluating")
    assert "500/1000" in out.getvalue() and "200 steps/s · 0:02 left · evaluating" in out.getvalue()


def test_what_an_earlier_run_has_done_says_nothing_about_the_speed(clock: Clock) -> None:
    progress = Progress(100, "draws", Console(quiet=True))
    progress.skip(40)
    assert progress.done == 40 and progress.describe() == ""
    clock.now += 40.0
    progress.advance_to(41)
    assert progress.describe() == "", "the first piece of work includes compiling"
    for done in (43, 45, 47, 50):
        clock.now += 4.5
        progress.advance_to(done)
    assert progress.describe() == "1:40 left"
