"""Fresh patients, whom nobody could know before: an agent and a maneuver on them, beside both on the public ones.

An agent made for the public patients is better on these. Where fresh ones are harder by chance, they are so for the
maneuver too.
"""

from __future__ import annotations

import hashlib
import hmac
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from pydantic import Field
from scipy import stats

from eval.benchmark.labels import Label, Text
from eval.benchmark.run import cell_of, times_of
from eval.benchmark.scores import score_of
from eval.benchmark.submission import AGENTS, FILE, PAGE, PATIENTS, Submission, cell_of_score
from eval.benchmark.tasks import TASKS
from eval.figures.statistics import Interval
from eval.kept.cells import Cell, play_cells
from eval.kept.entries import Entry
from eval.kept.parts import Run
from eval.rows import outcomes, times
from eval.rows.times import Times
from jawenv.base.files import InputModel, Number
from jawenv.base.reading import read_bytes

Array = npt.NDArray[np.float64]
CHECKED = "checked.json"
MANEUVER = "refined"
LEVEL = 0.01
"""How often a check may take honest agents for made for the public patients, over all scores of a submission."""
_MANEUVER = "\N{EN DASH}"  # in place of an agent's label, which this is not
_LEAST_S = 0.2  # earlier times count as this one in a ratio: a control step


class FreshScore(InputModel):
    """A score on public and on fresh patients, both played by the checker."""

    task: Text  # its id
    agent: Label  # label of the agent
    public_s: Number  # on the public patients, s
    fresh_s: Number  # on the fresh ones
    low_s: Number | None  # lower end of the latter's 95 % interval; None of one patient
    high_s: Number | None  # its upper end


class Checked(InputModel):
    """All that ``checked.json`` holds."""

    submission: Text  # digest of the submission's files
    key: Text  # by which the fresh patients were drawn, as hexadecimal digits
    patients: Annotated[int, Field(ge=2, strict=True)]  # how many of each task
    scores: tuple[FreshScore, ...]  # of each task and agent
    made_with: dict[str, Any]  # command, versions, commit, machine and time


@dataclass(frozen=True)
class _Comparison:
    """An agent and the maneuver on public and on fresh patients."""

    task: str  # its id
    agent: str  # label of the agent
    public: Interval  # score on the public patients
    fresh: Interval  # score on the fresh ones
    apart: Interval  # how much longer the latter is, s
    maneuver: tuple[Interval, Interval]  # both scores of the maneuver
    worse: Interval
    """Share by which the agent's times beside the maneuver's are longer on fresh patients (geometric mean)."""
    chance: float  # of so much or more in an agent that is as good on both


@dataclass(frozen=True)
class _OfSeeds(Times):
    """Times of patients whose seeds do not follow each other; the number of a patient is its place among them."""

    made_by = (outcomes, times)
    seeds: tuple[int, ...] = ()

    def play(self, entry: Entry, number: int, seed: int, progress: Callable[[int, int], None]) -> pd.DataFrame:
        """See `Rows`."""
        seeds = self.seeds[seed : seed + number]
        return self.rows_of(entry.play(number, seeds, progress, track_bound=False), 0).assign(seed=list(seeds))


def seeds_of(task: str, number: int, key: bytes, submission: str) -> tuple[int, ...]:
    """Seeds of fresh patients, 32 bits of HMAC-SHA256 each.

    Args:
        task: its id.
        number: how many.
        key: not known to anybody before the submission was.
        submission: digest of the submission's files.
    """
    texts = (f"{task}|{i}|{submission}" for i in range(number))
    return tuple(int.from_bytes(hmac.digest(key, text.encode(), "sha256")[:4], "big") for text in texts)


def digest_of(folder: Path) -> str:
    """SHA-256 of the names and contents of a submission's files."""
    files = [folder / name for name in (FILE, PATIENTS, PAGE)]
    copies = folder / AGENTS
    files += [] if copies.is_symlink() else sorted(path for path in copies.rglob("*") if not path.is_dir())
    content = hashlib.sha256()
    for file in files:
        content.update(file.relative_to(folder).as_posix().encode() + b"\0" + hashlib.sha256(read_bytes(file)).digest())
    return content.hexdigest()


def compare(
    folder: Path,
    submitted: Submission,
    public: pd.DataFrame,
    number: int,
    key: bytes,
    run: Run | None = None,
    *,
    trust: bool = False,
) -> tuple[_Comparison, ...]:
    """Play the agents of a submission on fresh patients, and the maneuver on these and the public ones.

    Args:
        folder: of the submission.
        submitted: its content, checked.
        public: rows of its agents on public patients, as the check played them.
        number: of fresh patients of each task.
        key: by which they are drawn.
        run: how they are played.
        trust: see `eval.benchmark.check.check`.
    """
    submission, cells = digest_of(folder), []
    seeds = {score.task: seeds_of(score.task, number, key, submission) for score in submitted.scores}
    for task in seeds:
        cell = cell_of(TASKS[task], MANEUVER, _MANEUVER, submitted.scores[0].patients)
        cells += [_placed(cell, "public"), _placed(_fresh(cell, seeds[task]), "fresh")]
    for score in submitted.scores:
        cell = cell_of_score(score, submitted, folder, trust=trust)
        cells.append(_placed(_fresh(cell, seeds[score.task]), "fresh"))
    with TemporaryDirectory() as work:
        rows = pd.concat([play_cells(cells, Path(work), run), public.assign(on="public")], ignore_index=True)
    return tuple(_comparison(score.task, score.agent, rows) for score in submitted.scores)


def _placed(cell: Cell, on: str) -> Cell:
    return replace(cell, levels={**cell.levels, "on": on})


def _fresh(cell: Cell, seeds: tuple[int, ...]) -> Cell:
    """The cell with other patients."""
    task = times_of(TASKS[str(cell.levels["task"])])
    rows = _OfSeeds(task.within, task.episode_s, task.comfort_limit_s, seeds)
    return replace(cell, seeds=range(len(seeds)), rows=rows)


def _comparison(task: str, agent: str, rows: pd.DataFrame) -> _Comparison:
    scores, times, ratios = [], [], []
    for on in ("public", "fresh"):
        of_task = rows[(rows["task"] == task) & (rows["on"] == on)]
        mine, its = (of_task[of_task["agent"] == who] for who in (agent, _MANEUVER))
        both = mine.merge(its, on="seed", suffixes=("", "_maneuver"))
        times.append(both["score_s"].to_numpy(dtype=np.float64))
        ratios.append(log_ratios(times[-1], both["score_s_maneuver"].to_numpy(dtype=np.float64)))
        scores += [score_of(mine), score_of(its[its["seed"].isin(mine["seed"])])]
    worse, chance = difference(*ratios)
    apart = difference(*times)[0]
    return _Comparison(task, agent, scores[0], scores[2], apart, (scores[1], scores[3]), _share(worse), chance)


def log_ratios(agent: Array, maneuver: Array) -> Array:
    """Logarithms of an agent's times beside the maneuver's, with the same patients."""
    mine, its = (np.maximum(times, _LEAST_S) for times in (agent, maneuver))
    return np.asarray(np.log(mine / its))


def _share(logarithm: Interval) -> Interval:
    return Interval(*(float(np.expm1(value)) for value in (logarithm.value, logarithm.low, logarithm.high)))


def difference(public: Array, fresh: Array) -> tuple[Interval, float]:
    """The excess of values on fresh patients with its 95 % interval, and the chance of it (Welch's test).

    Args:
        public: values of the public patients.
        fresh: those of fresh ones.
    """
    apart = float(fresh.mean() - public.mean())
    if not (np.ptp(public) or np.ptp(fresh)):  # as beside itself
        return Interval(apart, apart, apart), float(apart <= 0.0)
    with warnings.catch_warnings():  # few patients may all have the same time, whose variance is then 0 as it should be
        warnings.filterwarnings("ignore", "Precision loss occurred", RuntimeWarning)
        ends = stats.ttest_ind(fresh, public, equal_var=False).confidence_interval(0.95)
        chance = stats.ttest_ind(fresh, public, equal_var=False, alternative="greater").pvalue
    return Interval(apart, float(ends.low), float(ends.high)), float(chance)


def suspected(comparisons: Sequence[_Comparison]) -> list[_Comparison]:
    """The agents that do better on public patients than chance lets honest agents do (Bonferroni's rule)."""
    return [one for one in comparisons if one.chance < LEVEL / len(comparisons)]


def written(
    comparisons: Sequence[_Comparison], folder: Path, number: int, key: bytes, metadata: dict[str, Any]
) -> Checked:
    """The content of ``checked.json``.

    Args:
        comparisons: of ``compare``.
        folder: of the submission.
        number: see ``compare``.
        key: see ``compare``.
        metadata: of `eval.kept.tables.made_with`.
    """
    scores = []
    for one in comparisons:
        low, high = (one.fresh.low, one.fresh.high) if one.fresh.known else (None, None)
        scores.append(
            FreshScore(
                task=one.task,
                agent=one.agent,
                public_s=one.public.value,
                fresh_s=one.fresh.value,
                low_s=low,
                high_s=high,
            )
        )
    return Checked(
        submission=digest_of(folder), key=key.hex(), patients=number, scores=tuple(scores), made_with=metadata
    )
