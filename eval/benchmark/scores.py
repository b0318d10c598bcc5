"""The figures of each task and agent, with their intervals over the patients."""

from __future__ import annotations

import numpy as np
import pandas as pd

from eval.benchmark.tasks import TASKS
from eval.figures import statistics
from eval.figures.statistics import Interval
from eval.rows.times import LEVELS, restricted


def score_of(rows: pd.DataFrame) -> Interval:
    """The score of one agent in one task, s: the restricted mean of the patients' times; lower is better.

    Args:
        rows: of `eval.kept.cells.play_cells`, of one cell.
    """
    return statistics.mean(rows["score_s"].to_numpy(dtype=np.float64))


def by_cell(rows: pd.DataFrame) -> dict[tuple[str, str], pd.DataFrame]:
    """The patients' rows by task and agent, tasks in the order of `TASKS`, agents in the order of the rows.

    Args:
        rows: of `eval.kept.cells.play_cells`.
    """
    rows_of = {(str(task), str(agent)): cell for (task, agent), cell in rows.groupby(["task", "agent"], sort=False)}
    agents = list(dict.fromkeys(map(str, rows["agent"])))
    return {(task, agent): rows_of[task, agent] for task in TASKS for agent in agents if (task, agent) in rows_of}


def figures(task: str, rows: pd.DataFrame) -> dict[str, Interval]:
    """Figures beside a score, by heading.

    Args:
        task: id of the task.
        rows: of one cell.
    """
    within, episode_s = TASKS[task].within, TASKS[task].episode_s

    def mean_time(column: str) -> Interval:
        return statistics.mean(restricted(rows[column].to_numpy(dtype=np.float64), episode_s))

    reached = np.isfinite(rows[f"within_{within:g}_s"].to_numpy(dtype=np.float64))
    stopped = statistics.share(~rows["completed"].to_numpy(dtype=bool))
    return {
        "score, s": score_of(rows),
        "get there, %": _percent(statistics.share(reached)),
        **{f"within {100.0 * level:g} %, s": mean_time(f"within_{level:g}_s") for level in LEVELS},
        "claimed, s": mean_time("claimed_s"),
        "worst sd, %": _percent(statistics.quantile(rows["worst_sd"].to_numpy(dtype=np.float64), 0.5)),
        "discomfort, s": statistics.mean(rows["discomfort_s"].to_numpy(dtype=np.float64)),
        "stopped, %": _percent(stopped),
    }


def _percent(share: Interval) -> Interval:
    return Interval(100.0 * share.value, 100.0 * share.low, 100.0 * share.high)
