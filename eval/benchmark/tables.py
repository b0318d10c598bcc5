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
    "and accelerated bootstrap). The device keeps the task's budget of discomfort: without one the ranking rewards "
    "breaking a limit. `–`: trained for another environment, or plans in another one."
)
CHECK_NOTE = (
    "As many patients whom the key draws, for whom nobody could prepare: their mean score less that of the public "
    "ones, who rank, in s, with the 95 % interval of two independent samples (Welch 1947). By chance one interval in "
    "twenty leaves out 0."
)
TASK_HEAD = ("task", "what it asks", "model", "cohort", "knowledge", "device", "budget, s", "within", "seeds")
Cells = dict[tuple[str, str], Array]


def _cells(rows: pd.DataFrame, patients: str) -> Cells:
    """Scores of the public or of the drawn patients by task and agent, in the order of `TASKS` and of the rows."""
    chosen = rows[rows["patients"] == patients]
    of = {
        (str(task), str(agent)): cell.to_numpy(dtype=np.float64)
        for (task, agent), cell in chosen.groupby(["task", "agent"], sort=False)["score_s"]
    }
    agents = dict.fromkeys(map(str, rows["agent"]))
    return {(task, agent): of[task, agent] for task in TASKS for agent in agents if (task, agent) in of}


def _table(seconds: dict[tuple[str, str], Interval], note: str, title: str) -> Table:
    """An agent a row, a task a column."""
    tasks, agents = (dict.fromkeys(at[place] for at in seconds) for place in (0, 1))
    table = [
        [words.label(agent)]
        + [words.with_interval(seconds[task, agent], 2) if (task, agent) in seconds else "–" for task in tasks]
        for agent in agents
    ]
    return Table(["agent", *tasks], table, note=note, title=title)


def score_table(rows: pd.DataFrame) -> Table:
    """The scores of the public patients.

    Args:
        rows: of `eval.kept.cells.play_cells`.
    """
    cells = _cells(rows, PUBLIC)
    scores = {at: statistics.mean(seconds) for at, seconds in cells.items()}
    return _table(scores, NOTE, f"{VERSION}: s until the truth is found, lower is better")


def check_table(rows: pd.DataFrame) -> Table:
    """The scores of the drawn patients less those of the public ones."""
    public, drawn = _cells(rows, PUBLIC), _cells(rows, DRAWN)
    later = {at: statistics.difference(seconds, public[at]) for at, seconds in drawn.items()}
    return _table(later, CHECK_NOTE, "Drawn patients: how much later, s")


def task_row(task: Task) -> list[str]:
    """A task's row of settings."""
    device = ", ".join(f"{name} {value:g}" for name, value in task.device.items())
    seeds = f"{task.seeds[0]}–{task.seeds[-1]}"
    share = f"{words.percent(task.within, 0)} %"
    model = task.env.removeprefix("jawenv/")
    budget = f"{task.comfort_budget_s:g}"
    return [task.id, task.description, model, task.cohort, task.knowledge, device or "–", budget, share, seeds]


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
        Table(TASK_HEAD, [task_row(task) for task in tasks], range(len(TASK_HEAD) - 3)).markdown(),
    ]
    return "\n\n".join(lines) + "\n"
