"""The scores as tables: in Markdown, with what they were made with, and in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd
from rich.console import Console

from eval import words
from eval.benchmark.scores import by_cell, figures, score_of
from eval.benchmark.tasks import TASKS, VERSION, Task, digest
from eval.terminal import printed_table

NOTE = (
    "Seconds until every parameter is within the task's share of the truth, and stays there to the end of an episode "
    "in which no hard limit is crossed: means over the patients, who count as the whole episode where that never "
    "happens (restricted mean time). Lower is better. In brackets the 95 % interval over the patients (bias-corrected "
    "and accelerated bootstrap). `–`: trained in another environment."
)
DETAILS_NOTE = (
    "Get there: share of the patients (Wilson's interval). Within 20, 10, 5 %: the score with that share. "
    "Claimed: the restricted mean of the first time at which no sd that the filter states is above the task's share. "
    "Worst sd: median, at the end. Stopped: a hard limit was crossed, or the filter diverged."
)
_DIGITS = {"score, s": 2, "get there, %": 0, "worst sd, %": 2, "discomfort, s": 3}


def score_table(rows: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Head and rows: an agent a row, a task a column.

    Args:
        rows: of `eval.benchmark.run.play_cells`.
    """
    cells = by_cell(rows)
    tasks = list(dict.fromkeys(task for task, _ in cells))
    agents = dict.fromkeys(map(str, rows["agent"]))
    table = [
        [
            words.label(agent),
            *(
                words.with_interval(score_of(cells[task, agent]), 2) if (task, agent) in cells else "–"
                for task in tasks
            ),
        ]
        for agent in agents
    ]
    return ["agent", *tasks], table


def details_table(rows: pd.DataFrame) -> tuple[list[str], list[list[str]]]:
    """Head and rows: a task and an agent a row, with what stands beside the score."""
    table, head = [], ["task", "agent", "patients"]
    for (task, agent), cell in by_cell(rows).items():
        found = figures(task, cell)
        head = [*head[:3], *found]
        written = [words.with_interval(value, _DIGITS.get(name, 1)) for name, value in found.items()]
        table.append([task, words.label(agent), str(len(cell)), *written])
    return head, table


def task_row(task: Task) -> list[str]:
    """What tells a task apart."""
    device = ", ".join(f"{name} {value:g}" for name, value in task.device.items())
    seeds = f"{task.seeds[0]}–{task.seeds[-1]}"
    share = f"{words.percent(task.within, 0)} %"
    model = task.env.removeprefix("jawenv/")
    return [task.id, task.description, model, task.cohort, task.knowledge, device or "–", share, seeds]


TASK_HEAD = ["task", "what it asks", "model", "cohort", "knowledge", "device", "within", "seeds"]


def markdown(rows: pd.DataFrame, about: dict[str, Any]) -> str:
    """The page ``benchmark.md``.

    Args:
        rows: of `eval.benchmark.run.play_cells`.
        about: of `eval.kept.tables.made_with`.
    """
    versions, git, machine = about["versions"], about["git"], about["machine"]
    tasks = [task for task in TASKS.values() if task.id in set(rows["task"])]
    state = "" if git is None else f", commit {git['commit'][:12]}" + (" with changes" if git["changed"] else "")
    made = f"Made by `{about['command']}`, {about['finished']}: tasks {VERSION}, digest `{digest()}`"
    made += f". jawenv {versions['jawenv']}{state}; {machine['cores']} cores of {machine['processor']}."
    all_tasks = words.table(TASK_HEAD, map(task_row, tasks), range(len(TASK_HEAD) - 2))
    lines = [
        f"# Benchmark {VERSION}",
        "",
        made,
        "",
        _how_many(rows, tasks),
        "",
        words.table(*score_table(rows)),
        "",
        NOTE,
        "",
    ]
    lines += ["## Beside the scores", "", words.table(*details_table(rows), (0, 1)), "", DETAILS_NOTE, ""]
    lines += ["## Tasks", "", all_tasks, ""]
    return "\n".join(lines)


def _how_many(rows: pd.DataFrame, tasks: Sequence[Task]) -> str:
    """Whether all patients were played; where fewer were, it is no complete submission."""
    played = {task.id: rows.loc[rows["task"] == task.id, "seed"].nunique() for task in tasks}
    fewer = {
        task.id: f"the first {played[task.id]} of {task.patients}" for task in tasks if played[task.id] < task.patients
    }
    if not fewer:
        return "All patients of these tasks were played."
    if len(fewer) == len(tasks) and len(set(fewer.values())) == 1:
        return f"Of each task {next(iter(fewer.values()))} patients were played."
    return f"Not all patients were played: {'; '.join(f'{many} in {task}' for task, many in fewer.items())}."


def show(rows: pd.DataFrame, console: Console) -> None:
    """Print the scores."""
    head, table = score_table(rows)
    printed = printed_table(f"{VERSION}: s until the truth is found, lower is better")
    for name in head:
        printed.add_column(name.replace("-", "-\n"))
    for row in table:
        printed.add_row(*row)
    console.print(printed)
