"""The tasks are frozen."""

from pathlib import Path

from eval.benchmark.tables import task_row
from eval.benchmark.tasks import TASKS, VERSION, digest


def test_the_tasks_are_those_of_their_version():
    assert VERSION == "jawenv-3"
    assert list(TASKS) == [
        "hinge-exact",
        "jaw-exact",
        "jaw-wide-exact",
        "jaw-one-sided-exact",
        "jaw-imaged",
        "jaw-imaged-memory",
        "jaw-asked",
    ]
    assert digest() == "88d828f9b580c981", "a task has changed: give the benchmark a new version, and play it anew"


def test_the_page_has_every_task():
    page = (Path(__file__).parents[3] / "docs" / "tables" / "benchmark.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith(("| hinge", "| jaw"))]
    assert rows == ["| " + " | ".join(task_row(task)) + " |" for task in TASKS.values()]
