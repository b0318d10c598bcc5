"""The tasks are frozen."""

from pathlib import Path

import pytest

from eval.benchmark.tables import task_row
from eval.benchmark.tasks import TASKS, VERSION, digest, tasks_named
from eval.kept.entries import Settings
from jawenv.base.errors import InputError


def test_the_tasks_are_those_of_their_version():
    assert VERSION == "jawenv-2"
    assert list(TASKS) == [
        "hinge-exact",
        "jaw-exact",
        "jaw-wide-exact",
        "jaw-one-sided-exact",
        "jaw-imaged",
        "jaw-imaged-memory",
        "jaw-asked",
    ]
    assert digest() == "6ffb4eae9d5fd455", "a task has changed: give the benchmark a new version, and play it anew"


def test_what_every_task_has_in_common():
    for name, task in TASKS.items():
        assert task.id == name
        assert (task.control, task.patients) == ("targets", 100)
        assert task.episode_s == (10.0 if name == "jaw-asked" else 30.0)


def test_a_task_has_the_numbers_behind_its_names():
    settings = TASKS["jaw-imaged-memory"].settings(3)
    assert settings.patients == 3 and settings.seed == 55_000
    assert settings.world == Settings.of(env="JawImaged").world
    frozen = TASKS["jaw-imaged-memory"].frozen()
    assert frozen["device"]["unmodelled_time_s"] == 0.5 and frozen["device"]["slew_N_s"] == 24.0
    assert frozen["cohort"]["groups"]
    assert "unmodelled_time_s" not in TASKS["jaw-imaged"].frozen()["device"]


def test_an_unknown_task_is_refused():
    assert [task.id for task in tasks_named(["jaw-imaged", "jaw-exact"])] == ["jaw-exact", "jaw-imaged"]
    with pytest.raises(InputError):
        tasks_named(["jaw"])
    with pytest.raises(InputError):
        tasks_named([])


def test_the_page_has_every_task():
    page = (Path(__file__).parents[3] / "docs" / "tables" / "benchmark.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith(("| hinge", "| jaw"))]
    assert rows == ["| " + " | ".join(task_row(task)) + " |" for task in TASKS.values()]
