"""The scores as tables: in Markdown, with command and versions, and in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from eval.benchmark.scores import by_cell, figures, score_of
from eval.benchmark.tasks import TASKS, VERSION, Task, digest
from eval.figures import words
from eval.figures.tables import Table, made_by

NOTE = (
    "Seconds until every parameter is within the task's share of the truth, and stays there to the end of an episode "
    "in which no hard limit is crossed: means over the patients, who count as the whole episode where that never "
    "happens (restricted mean time). Lower is better. In brackets the 95 % interval over the patients (bias-corrected "
    "and accelerated bootstrap). `–`: trained for another environment, or plans in another one."
)
DETAILS_NOTE = (
    "Get there: share of the patients (Wilson's interval). Within 20, 10, 5 %: the score with that share. "
    "Claimed: the restricted mean of the first time at which no sd that the filter states is above the task's share. "
    "Worst sd: median, at the end. Stopped: a hard limit was crossed, or the filter diverged."
)
_DIGITS = {"score, s": 2, "get there, %": 0, "worst sd, %": 2, "discomfort, s": 3}


TASK_HEAD = ("task", "what it asks", "model", "cohort", "knowledge", "device", "within", "seeds")


def score_table(rows: pd.DataFrame) -> Table:
    """An agent a row, a task a column.

    Args:
        rows: of `eval.kept.cells.play_cells`.
    """
    cells = by_cell(rows)
    tasks = list(dict.fromkeys(task for task, _ in cells))
    table = [
        [words.label(agent)]
        + [words.with_interval(score_of(cells[task, agent]), 2) if (task, agent) in cells else "–" for task in tasks]
        for agent in dict.fromkeys(map(str, rows["agent"]))
    ]
    return Table(["agent", *tasks], table, note=NOTE, title=f"{VERSION}: s until the truth is found, lower is better")


def _details_table(rows: pd.DataFrame) -> Table:
    """A task and an agent a row, with the figures beside the score."""
    table, head = [], ["task", "agent", "patients"]
    for (task, agent), cell in by_cell(rows).items():
        beside = figures(task, cell)
        head = [*head[:3], *beside]
        written = [words.with_interval(value, _DIGITS.get(name, 1)) for name, value in beside.items()]
        table.append([task, words.label(agent), str(len(cell)), *written])
    return Table(head, table, (0, 1), DETAILS_NOTE)


def task_row(task: Task) -> list[str]:
    """A task's row of settings."""
    device = ", ".join(f"{name} {value:g}" for name, value in task.device.items())
    seeds = f"{task.seeds[0]}–{task.seeds[-1]}"
    share = f"{words.percent(task.within, 0)} %"
    model = task.env.removeprefix("jawenv/")
    return [task.id, task.description, model, task.cohort, task.knowledge, device or "–", share, seeds]


def markdown(rows: pd.DataFrame, metadata: dict[str, Any]) -> str:
    """The page ``benchmark.md``.

    Args:
        rows: of `eval.kept.cells.play_cells`.
        metadata: of `eval.kept.tables.made_with`.
    """
    tasks = [task for task in TASKS.values() if task.id in set(rows["task"])]
    lines = [
        f"# Benchmark {VERSION}",
        made_by(metadata, f"tasks {VERSION}, digest `{digest()}`"),
        _how_many(rows, tasks),
        score_table(rows).markdown(),
        "## Beside the scores",
        _details_table(rows).markdown(),
        "## Tasks",
        Table(TASK_HEAD, [task_row(task) for task in tasks], range(len(TASK_HEAD) - 2)).markdown(),
    ]
    return "\n\n".join(lines) + "\n"


def _how_many(rows: pd.DataFrame, tasks: Sequence[Task]) -> str:
    """Whether all patients were played."""
    played = {task.id: rows.loc[rows["task"] == task.id, "seed"].nunique() for task in tasks}
    fewer = {
        task.id: f"the first {played[task.id]} of {task.patients}" for task in tasks if played[task.id] < task.patients
    }
    if not fewer:
        return "All patients of these tasks were played."
    if len(fewer) == len(tasks) and len(set(fewer.values())) == 1:
        return f"Of each task {next(iter(fewer.values()))} patients were played."
    return f"Not all patients were played: {'; '.join(f'{many} in {task}' for task, many in fewer.items())}."
