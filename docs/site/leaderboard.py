"""The leaderboard: the benchmark's baselines and submissions, each task's score as points.

A submission's scores are those that the checker played on fresh patients (`eval.benchmark.fresh`), where there are any.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

from purposes import purpose
from table_page import FOLDER, first_table

from agents.planners import PLANNERS
from eval.benchmark import fresh, submission
from eval.benchmark.check import CANNOT_KNOW
from eval.benchmark.tasks import TASKS, VERSION
from eval.figures import words
from eval.figures.tables import Marked, Table, plain
from jawenv.base.errors import InputError
from jawenv.base.files import read_model
from jawenv.playing.excitation import BASELINES
from jawenv.playing.maneuvers import maneuver_names
from jawenv.playing.maneuvers.maneuver import FOLDER as MANEUVERS
from jawenv.playing.policies.card import policy_names

TABLE = FOLDER / "benchmark.md"
SUBMISSIONS = Path(__file__).parents[1] / "submissions"
STILL, CLAIRVOYANT = "hold_still", "clairvoyant"
TITLE = re.compile(r"^# Benchmark (\S+)$", re.M)
ELSEWHERE, UNCHECKED = "From elsewhere", "From elsewhere, not checked"
Scores = dict[str, dict[str, float]]
"""Agent -> task -> s; tasks that it does not play are left out."""
HOW = f"""## How to submit

1. In a clone without changes, play all patients: `python -m eval benchmark AGENT --output docs/submissions/NAME`.
2. Delete `parts/` in that folder, and open a pull request with the rest ([what it holds](benchmark.md#submission)).
3. A maintainer plays it again, with `--fresh-seeds 50` on patients whom nobody could know:
   `python -m eval benchmark --check docs/submissions/NAME --fresh-seeds 50`. That writes `checked.json` anew.
4. When the request is merged, this page has its points, of the fresh patients. Without that check it stands last.

Tasks are those of `{VERSION}`; submissions of another version are left out.

## What a check proves

A check proves that the submitted agent gets these scores on these patients with this code. It cannot know:
"""
LEFT_OUT = "\n## Left out\n"


def page() -> str:
    """The page as Markdown."""
    version, baselines = _read(TABLE)
    submitted, checked, left_out = _submissions()
    if version != VERSION:
        left_out += [f"{name}: is of {VERSION}, the scores above of {version}" for name in submitted]
        submitted = {}
    banner = f"**Older patients.** These are scores of `{version}`; tasks are now `{VERSION}`.\n\n"
    limits = "\n".join(f"- {line};" for line in CANNOT_KNOW).removesuffix(";") + "."
    without = "".join(f"\n- {plain(line)}" for line in left_out)
    return (
        "# Leaderboard\n\nSee here which agent finds the truth soonest, and submit your own. "
        "Tasks: [benchmark](benchmark.md). Scores in seconds with intervals: [table](tables.md#benchmark).\n\n"
        f"{banner if version != VERSION else ''}{_table(baselines, submitted, checked).markdown()}\n\n{HOW}\n{limits}\n"
        f"{without and f'{LEFT_OUT}{without}{chr(10)}'}"
    )


def _submissions() -> tuple[Scores, set[str], list[str]]:
    """Scores of submissions, who of them was checked on fresh patients, and a line for each that is left out."""
    scores: Scores = {}
    checked, left_out = set(), []
    for folder in sorted(path for path in SUBMISSIONS.glob("*") if path.is_dir()):
        try:
            given = submission.read(folder)
            played = _fresh_times(folder)
        except InputError as error:
            left_out.append(str(error).replace(f"{SUBMISSIONS}/", ""))
            continue
        for score in given.scores:
            name = f"{score.agent} ({folder.name})"
            scores.setdefault(name, {})[score.task] = played.get((score.task, score.agent), score.score_s)
            checked |= {name} if played else set()
    return scores, checked, left_out


def _fresh_times(folder: Path) -> dict[tuple[str, str], float]:
    """Scores on fresh patients, by task and agent; none where nobody has checked the submission as it is."""
    path = folder / fresh.CHECKED
    if not path.exists():
        return {}
    found = read_model(path, fresh.Checked)
    if found.submission != fresh.digest_of(folder):
        raise InputError(f"{path}: is of other files; check the submission again")
    for score in found.scores:
        submission.check_times(path, score.task, (score.fresh_s,))
    return {(score.task, score.agent): score.fresh_s for score in found.scores}


def _read(path: Path) -> tuple[str, Scores]:
    """Version and scores of a ``benchmark.md``."""
    text = path.read_text(encoding="utf-8")
    scores: Scores = {}
    for row in first_table(text):
        name = row.pop("agent").replace(" ", "_")
        scores[name] = {task: float(cell.split(" ")[0]) for task, cell in row.items() if cell != words.NOTHING}
    return TITLE.findall(text)[0], scores


def _table(baselines: Scores, submitted: Scores, checked: set[str]) -> Table:
    """Points of every agent, the best first, below the seconds that they are reckoned from."""
    tasks = list(dict.fromkeys(task for times in baselines.values() for task in times))
    ends = {task: _ends(task, baselines) for task in tasks}
    points = {
        name: {task: _points(times[task], ends[task]) for task in tasks if task in times}
        for name, times in (baselines | submitted).items()
        if name != STILL
    }
    mean = {name: sum(row.values()) / len(tasks) for name, row in points.items()}
    groups = {name: _group(name) for name in baselines}
    groups |= {name: ELSEWHERE if name in checked else UNCHECKED for name in submitted}
    table = [
        [Marked(f"*{text}*"), "", "", "", *(f"{ends[task][number]:.2f} s" for task in tasks)]
        for number, text in enumerate(("0 points", "100 points"))
    ]
    for name in sorted(points, key=lambda name: (groups[name] == UNCHECKED, -mean[name])):
        cells = [words.number(points[name].get(task, math.nan), 0) for task in tasks]
        table.append([words.label(name), groups[name], words.number(mean[name], 0), str(len(points[name])), *cells])
    note = f"{_scale(tasks, baselines)} Mean: over all tasks; one that an agent does not play counts 0."
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
    return "Random actions" if name in BASELINES else ELSEWHERE
