"""The leaderboard: the benchmark's baselines and submissions, each task's score as points."""

from __future__ import annotations

import math
import re
from pathlib import Path

from purposes import purpose
from table_page import FOLDER, first_table

from agents.planners import PLANNERS
from eval.benchmark.check import CANNOT_KNOW
from eval.benchmark.tasks import TASKS, VERSION
from eval.figures import words
from eval.figures.tables import Table
from jawenv.playing.excitation import BASELINES
from jawenv.playing.maneuvers import maneuver_names
from jawenv.playing.maneuvers.maneuver import FOLDER as MANEUVERS
from jawenv.playing.policies.card import policy_names

TABLE = FOLDER / "benchmark.md"
SUBMISSIONS = Path(__file__).parents[1] / "submissions"
STILL, CLAIRVOYANT = "hold_still", "clairvoyant"
TITLE = re.compile(r"^# Benchmark (\S+)$", re.M)
GROUPS = ("Learned", "Planned", "Searched", "Made by hand", "Random actions", "From elsewhere")
Scores = dict[str, dict[str, float]]
"""Agent -> task -> s; tasks that it does not play are left out."""
HOW = f"""## How to submit

1. In a clone without changes, play all patients: `python -m eval benchmark AGENT --output docs/submissions/NAME`.
2. Delete `parts/` in that folder, and open a pull request with the rest ([what it holds](benchmark.md#submission)).
3. A maintainer plays it again: `python -m eval benchmark --check docs/submissions/NAME`.
4. When the request is merged, this page has its points.

Tasks are those of `{VERSION}`; submissions of another version are left out.

## What a check proves

A check proves that the submitted agent gets these scores on these patients with this code. It cannot know:
"""


def page() -> str:
    """The page as Markdown."""
    version, baselines = _read(TABLE)
    scores = dict(baselines)
    for path in sorted(SUBMISSIONS.glob("*/benchmark.md")):
        submitted, more = _read(path)
        scores |= {f"{name} ({path.parent.name})": times for name, times in more.items() if submitted == version}
    banner = f"**Older patients.** These are scores of `{version}`; tasks are now `{VERSION}`.\n\n"
    limits = "\n".join(f"- {line};" for line in CANNOT_KNOW).removesuffix(";") + "."
    return (
        "# Leaderboard\n\nSee here which agent finds the truth soonest, and submit your own. "
        "Tasks: [benchmark](benchmark.md). Scores in seconds with intervals: [table](tables.md#benchmark).\n\n"
        f"{banner if version != VERSION else ''}{_table(scores, baselines).markdown()}\n\n{HOW}\n{limits}\n"
    )


def _read(path: Path) -> tuple[str, Scores]:
    """Version and scores of a ``benchmark.md``."""
    text = path.read_text(encoding="utf-8")
    scores: Scores = {}
    for row in first_table(text):
        name = row.pop("agent").replace(" ", "_")
        scores[name] = {task: float(cell.split(" ")[0]) for task, cell in row.items() if cell != words.NOTHING}
    return TITLE.findall(text)[0], scores


def _table(scores: Scores, baselines: Scores) -> Table:
    """Points of every agent, best of its group first, below the seconds that they are reckoned from."""
    tasks = list(dict.fromkeys(task for times in baselines.values() for task in times))
    ends = {task: _ends(task, baselines) for task in tasks}
    points = {
        name: {task: _points(time, ends[task]) for task, time in times.items()}
        for name, times in scores.items()
        if name != STILL
    }
    mean = {name: sum(row.values()) / max(len(row), 1) for name, row in points.items()}
    table = [
        [f"*{text}*", "", "", "", *(f"{ends[task][number]:.2f} s" for task in tasks)]
        for number, text in enumerate(("0 points", "100 points"))
    ]
    for name in sorted(points, key=lambda name: (GROUPS.index(_group(name)), -mean[name])):
        cells = [words.number(points[name].get(task, math.nan), 0) for task in tasks]
        table.append([words.label(name), _group(name), words.number(mean[name], 0), str(len(points[name])), *cells])
    note = f"{_scale(tasks, baselines)} Mean: of the tasks that the agent plays; their number stands beside it."
    return Table(["agent", "group", "mean", "tasks", *tasks], table, (0, 1), note)


def _points(time: float, ends: tuple[float, float]) -> float:
    """Where a score lies between both ends; 0 for a task in which the latter is no better than the former."""
    zero, full = ends
    return 100.0 * (zero - time) / (zero - full) if full < zero else 0.0


def _scale(tasks: list[str], baselines: Scores) -> str:
    """What 0 and 100 points are, in tasks with the scores of both ends and in those without."""
    still = [task for task in tasks if task not in baselines.get(STILL, {})]
    best = {task: _best(task, baselines) for task in tasks}
    others = [f"{task} ({words.label(name)})" for task, name in best.items() if not name.startswith(CLAIRVOYANT)]
    places = "all tasks" if still == tasks else ", ".join(still)
    zero = f"; the whole episode in {places}, where nobody has held still" if still else ""
    full = f"; the best baseline in {', '.join(others)}, where no such planner has played" if others else ""
    return f"0 points: holding still{zero}. 100 points: a planner that knows the truth{full}."


def _ends(task: str, scores: Scores) -> tuple[float, float]:
    """Seconds of 0 and of 100 points in a task."""
    zero = scores.get(STILL, {}).get(task, TASKS[task].episode_s)
    return zero, scores[_best(task, scores)][task]


def _best(task: str, scores: Scores) -> str:
    """Who has 100 points: the best clairvoyant, or the best of all where none has played."""
    times = {name: row[task] for name, row in scores.items() if task in row}
    among = [name for name in times if name.startswith(CLAIRVOYANT)] or list(times)
    return min(among, key=times.__getitem__)


def _group(name: str) -> str:
    if name in policy_names():
        return "Learned"
    if name in PLANNERS:
        return "Planned"
    if name in maneuver_names():
        return "Searched" if purpose(MANEUVERS / f"{name}.yaml") else "Made by hand"
    return "Random actions" if name in BASELINES else "From elsewhere"
