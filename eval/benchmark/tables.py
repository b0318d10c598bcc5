"""The scores as tables: in Markdown, with command and versions, and in the terminal."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from eval.benchmark.run import DRAWN, PUBLIC
from eval.benchmark.tasks import TASKS, VERSION, Task, digest
from eval.figures import statistics, words
from eval.figures.statistics import Array, Interval
from eval.figures.tables import Table, code, made_by

NOTE = (
    "Seconds until every parameter is within the task's share of the truth, and stays there to the end of an episode "
    "in which no hard limit is crossed: means over the patients, who count as the whole episode where that never "
    "happens (restricted mean time). Lower is better. In brackets the 95 % interval over the patients (bias-corrected "
    "and accelerated bootstrap). `–`: trained for another environment, or plans in another one."
)
CHECK_NOTE = (
    "The same score with as many patients whom the key draws, for whom nobody could prepare; the public ones rank. "
    "Later: their mean score less that of the public ones, with the 95 % interval of two independent samples (Welch "
    "1947). By chance one interval in twenty leaves out 0."
)
TASK_HEAD = ("task", "what it asks", "model", "cohort", "knowledge", "device", "within", "seeds")
Cells = dict[tuple[str, str], pd.DataFrame]


def _cells(rows: pd.DataFrame, patients: str) -> Cells:
    """Rows of the public or of the drawn patients by task and agent, in the order of `TASKS` and of the rows."""
    chosen = rows[rows["patients"] == patients]
    of = {(str(task), str(agent)): cell for (task, agent), cell in chosen.groupby(["task", "agent"], sort=False)}
    agents = dict.fromkeys(map(str, rows["agent"]))
    return {(task, agent): of[task, agent] for task in TASKS for agent in agents if (task, agent) in of}


def _numbers(cell: pd.DataFrame, column: str) -> Array:
    return cell[column].to_numpy(dtype=np.float64)


def _score(cell: pd.DataFrame) -> Interval:
    return statistics.mean(_numbers(cell, "score_s"))


def score_table(rows: pd.DataFrame) -> Table:
    """The scores of the public patients: an agent a row, a task a column.

    Args:
        rows: of `eval.kept.cells.play_cells`.
    """
    cells = _cells(rows, PUBLIC)
    tasks, agents = (dict.fromkeys(key[place] for key in cells) for place in (0, 1))
    table = [
        [words.label(agent)]
        + [words.with_interval(_score(cells[task, agent]), 2) if (task, agent) in cells else "–" for task in tasks]
        for agent in agents
    ]
    return Table(["agent", *tasks], table, note=NOTE, title=f"{VERSION}: s until the truth is found, lower is better")


def check_table(rows: pd.DataFrame) -> Table:
    """The scores of the drawn patients beside those of the public ones: a task and an agent a row."""
    public, table = _cells(rows, PUBLIC), []
    for (task, agent), cell in _cells(rows, DRAWN).items():
        later = statistics.difference(_numbers(cell, "score_s"), _numbers(public[task, agent], "score_s"))
        scores = (_score(public[task, agent]), _score(cell), later)
        table.append([task, words.label(agent), *(words.with_interval(score, 2) for score in scores)])
    head = ["task", "agent", "public, s", "drawn, s", "later, s"]
    return Table(head, table, (0, 1), CHECK_NOTE, "Drawn patients: a check")


def task_row(task: Task) -> list[str]:
    """A task's row of settings."""
    device = ", ".join(f"{name} {value:g}" for name, value in task.device.items())
    seeds = f"{task.seeds[0]}–{task.seeds[-1]}"
    share = f"{words.percent(task.within, 0)} %"
    model = task.env.removeprefix("jawenv/")
    return [task.id, task.description, model, task.cohort, task.knowledge, device or "–", share, seeds]


def markdown(rows: pd.DataFrame, metadata: dict[str, Any], key: str) -> str:
    """The page ``benchmark.md``.

    Args:
        rows: of `eval.kept.cells.play_cells`.
        metadata: of `eval.kept.tables.made_with`.
        key: of the drawn patients.
    """
    tasks = [task for task in TASKS.values() if task.id in set(rows["task"])]
    played = rows[rows["patients"] == PUBLIC].groupby("task")["seed"].nunique()
    fewer = [f"{played[task.id]} of {task.patients} in {task.id}" for task in tasks if played[task.id] < task.patients]
    lines = [
        f"# Benchmark {VERSION}",
        made_by(metadata, f"tasks {VERSION}, digest `{digest()}`"),
        f"Not all patients were played: {'; '.join(fewer)}." if fewer else "All patients of these tasks were played.",
        score_table(rows).markdown(),
        "## Drawn patients",
        f"Drawn by {code(f'--key {key}')}.",
        check_table(rows).markdown(),
        "## Tasks",
        Table(TASK_HEAD, [task_row(task) for task in tasks], range(len(TASK_HEAD) - 2)).markdown(),
    ]
    return "\n\n".join(lines) + "\n"
