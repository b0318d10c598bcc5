"""Whether a submission reproduces: its files, its figures, and its patients played again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from agents.own import names_own
from eval.benchmark import submission
from eval.benchmark.run import Cell, parts_of_cell, play_parts
from eval.benchmark.scores import by_cell
from eval.benchmark.submission import PATIENTS, Submission, SubmittedAgent, SubmittedScore
from eval.benchmark.tasks import PATIENTS_IN_A_PART, TASKS
from eval.benchmark.times import COLUMNS
from eval.kept.parts import Part, Run
from eval.kept.tables import read_table
from jawenv.controls import mode_of
from jawenv.errors import InputError, shown

_ROUNDING = 1e-9


@dataclass(frozen=True)
class Checked:
    """What a check has found.

    Attributes:
        played: how many episodes were played again.
        equal: how many of them have the same score to the digit.
        faults: what does not reproduce, a line each; none if all does.
    """

    played: int
    equal: int
    faults: tuple[str, ...]


def check(
    folder: Path, patients: int | None = None, seed: int = 0, run: Run | None = None, *, trust: bool = False
) -> Checked:
    """Play a submission again.

    A patient reproduces if the score is the same but for one control step: another processor rounds otherwise.

    Args:
        folder: of the submission.
        patients: of each task and agent so many at least, drawn in whole parts; all by default.
        seed: of the draw.
        run: how it is played.
        trust: whether modules that the submission names may be imported, and checkpoints unpickled.

    Raises:
        InputError: a file is missing or damaged, is of other tasks, or needs trust.
    """
    given = submission.read(folder)
    rows = read_table(folder / PATIENTS, ("task", "agent", *COLUMNS), "get the submission again")[0]
    faults = [*_of_agents(given, folder, trust), *_of_figures(given, rows)]
    if faults:
        return Checked(0, 0, tuple(faults))
    cells = [_cell(score, given, folder, trust) for score in given.scores]
    with TemporaryDirectory() as place:
        draw = np.random.default_rng(seed)
        parts: list[tuple[Cell, Part]] = []
        for cell, score in zip(cells, given.scores, strict=True):
            every = parts_of_cell(cell, Path(place), score.patients)
            parts += [(cell, part) for part in drawn(every, patients, draw)]
        again = play_parts(parts, run)
    return _compared(rows, again, cells)


def _of_agents(given: Submission, folder: Path, trust: bool) -> list[str]:
    """Agents whose files are others than when they were played."""
    labels = [each.agent for each in given.agents]
    faults = [
        f"{score.agent}: has scores, but is no agent of the submission"
        for score in given.scores
        if score.agent not in labels
    ]
    for each in given.agents:
        if each.copy_at is None and names_own(each.spec) and not trust:
            raise InputError(
                f"{each.agent} is the module {shown(each.spec)}, which runs code; allowed if you trust it: --trust"
            )
        if submission.fingerprint_of(_spec(each, folder)) != each.fingerprint:
            faults.append(f"{each.agent}: its files have changed since it was played")
    return faults


def _of_figures(given: Submission, rows: pd.DataFrame) -> list[str]:
    """Scores that do not follow from the patients' rows."""
    cells = by_cell(rows)
    named = {(score.task, score.agent) for score in given.scores}
    faults = [f"{task}, {agent}: patients without a score" for task, agent in cells if (task, agent) not in named]
    for score in given.scores:
        cell = cells.get((score.task, score.agent))
        if cell is None:
            faults.append(f"{score.task}, {score.agent}: a score without patients")
            continue
        seeds = TASKS[score.task].seeds[: len(cell)]
        if sorted(cell["seed"]) != list(seeds):
            faults.append(f"{score.task}, {score.agent}: the patients are not those of seeds {seeds[0]} to {seeds[-1]}")
        made = submission.scored(score.task, score.agent, cell, score.note)
        if not _same(made, score):
            faults.append(
                f"{score.task}, {score.agent}: the score is {score.score_s:.4g} s of {score.patients} patients, "
                f"the table gives {made.score_s:.4g} s of {made.patients}"
            )
    return faults


def _same(one: SubmittedScore, other: SubmittedScore) -> bool:
    figures = [[score.score_s, score.low_s, score.high_s] for score in (one, other)]
    mine, theirs = (np.array([np.nan if value is None else value for value in each]) for each in figures)
    return one.patients == other.patients and bool(np.allclose(mine, theirs, rtol=_ROUNDING, atol=0.0, equal_nan=True))


def _cell(score: SubmittedScore, given: Submission, folder: Path, trust: bool) -> Cell:
    agent = next(each for each in given.agents if each.agent == score.agent)
    return Cell(TASKS[score.task], score.agent, _spec(agent, folder), score.note, trust)


def _spec(agent: SubmittedAgent, folder: Path) -> str:
    return agent.spec if agent.copy_at is None else str(folder / agent.copy_at)


def drawn(parts: Sequence[Part], patients: int | None, draw: np.random.Generator) -> list[Part]:
    """Parts that have so many patients at least; all of them where none are asked for."""
    if patients is None:
        return list(parts)
    number = min(-(-patients // PATIENTS_IN_A_PART), len(parts))
    return [parts[place] for place in sorted(draw.choice(len(parts), number, replace=False))]


def _compared(rows: pd.DataFrame, again: pd.DataFrame, cells: Sequence[Cell]) -> Checked:
    """Rows of the submission beside those that were played again."""
    keys = ["task", "agent", "seed"]
    both = again[[*keys, "score_s"]].merge(rows[[*keys, "score_s"]], on=keys, suffixes=("", "_given"), validate="1:1")
    steps = _steps(cells)
    apart = (both["score_s"] - both["score_s_given"]).abs()
    allowed = pd.Series([steps[task, agent] for task, agent in zip(both["task"], both["agent"], strict=True)])
    wrong = both[(apart > allowed + _ROUNDING).to_numpy()]
    faults = []
    for (task, agent), cell in wrong.groupby(["task", "agent"], sort=False):
        one = cell.iloc[0]
        faults.append(
            f"{task}, {agent}: {len(cell)} patients differ, as seed {one['seed']}: "
            f"{one['score_s_given']:.4g} s given, {one['score_s']:.4g} s played"
        )
    return Checked(len(both), int((apart <= _ROUNDING).sum()), tuple(faults))


def _steps(cells: Sequence[Cell]) -> Mapping[tuple[str, str], float]:
    """Length of a control step, s, by task and agent."""
    return {(cell.task.id, cell.agent): 1.0 / mode_of(cell.load().env_kwargs).steps_per_s for cell in cells}
