"""Check that a submission reproduces: its files, its figures, and its patients played again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from eval.benchmark import differences, submission, tables
from eval.benchmark.labels import is_label_of
from eval.benchmark.scores import by_cell
from eval.benchmark.submission import PAGE, PATIENTS, Submission, SubmittedScore
from eval.benchmark.tasks import PATIENTS_IN_A_PART, TASKS
from eval.kept.cells import Cell, play_parts
from eval.kept.parts import Part, Run
from eval.kept.tables import read_table
from eval.rows.times import COLUMNS
from jawenv.base import versions
from jawenv.base.errors import InputError, shown
from jawenv.base.named_objects import is_named
from jawenv.base.reading import read_text
from jawenv.controls import mode_of

_ROUNDING = 1e-9
_COLUMNS = ("task", "agent", *COLUMNS)
_KINDS = {"task": "O", "agent": "O", "seed": "i", "violated": "b", "completed": "b"}  # of NumPy; others are floats
_LONGEST_S = max(task.episode_s for task in TASKS.values())
_REMEDY = "get the submission again"
CANNOT_KNOW = (
    "whether an agent was made for these patients, whose seeds are public, unless fresh ones are played",
    "whether a module reads or changes files and other processes of this machine, whose rights it has",
    "who made the submission, when, and on what: command, commit and machine are what it says",
)
"""Limits of any check."""


@dataclass(frozen=True)
class Checked:
    """Result of a check."""

    played: int  # how many episodes were played again
    equal: int  # how many of them have the same score to the digit
    faults: tuple[str, ...]  # differences, a line each; none if all reproduces
    patients: int = 0  # of each score; 0 where nothing was played
    exact: bool = False  # whether every column was compared to the bit, on the platform that made them
    rows: pd.DataFrame = field(default_factory=pd.DataFrame, repr=False, compare=False)
    """Of the episodes that were played again."""


def check(folder: Path, patients: int | None = None, run: Run | None = None, *, trust: bool = False) -> Checked:
    """Play a submission again.

    On the platform that made it every column is compared to the bit. On another one, which rounds otherwise, times
    may differ by a control step and other columns by a tenth, unless the differences lean one way.

    Args:
        folder: of the submission.
        patients: of each task and agent so many, drawn by entropy of this machine's; with each the part is played in
            which it lies. All by default.
        run: how it is played.
        trust: whether modules of the submission may be run, and its stable-baselines3 checkpoints unpickled.
    """
    submitted = submission.read(folder)
    rows = _read_patients(folder / PATIENTS, submitted.made_with)
    faults = [*_of_agents(submitted, folder, trust), *_of_figures(submitted, rows)]
    if not faults and read_text(folder / PAGE) != tables.markdown(rows, submitted.made_with):
        faults = [f"{PAGE}: is not the page of these patients"]
    if faults:
        return Checked(0, 0, tuple(faults))
    cells = [submission.cell_of_score(score, submitted, folder, trust=trust) for score in submitted.scores]
    faults, steps = _of_entries(cells, submitted)
    if faults:
        return Checked(0, 0, tuple(faults))
    with TemporaryDirectory() as work:
        draw = np.random.default_rng()
        parts: list[tuple[Cell, Part]] = []
        for cell in cells:
            parts += [(cell, part) for part in drawn(cell.parts(Path(work)), patients, draw)]
        again = play_parts(parts, run)
    exact = _platform(submitted.made_with) == _platform(versions.made_with())
    faults = differences.faults_of(rows, again, None if exact else steps)
    both = again.merge(rows, on=differences.KEYS, suffixes=("", "_given"))
    equal = int((both["score_s"] == both["score_s_given"]).sum())
    return Checked(len(again), equal, tuple(faults), submitted.scores[0].patients, exact, again)


def _platform(made_with: Mapping[str, Any]) -> list[Any]:
    machine = made_with["machine"]
    return [machine["processor"], machine["system"], made_with["versions"]]


def _read_patients(path: Path, made_with: Mapping[str, Any]) -> pd.DataFrame:
    """Read ``benchmark.parquet``.

    Args:
        path: of the file.
        made_with: metadata of the submission.
    """
    rows, metadata = read_table(path, _COLUMNS, _REMEDY)
    if metadata != made_with:
        raise InputError(f"{path}: was made with something else than the submission says; {_REMEDY}")
    if list(rows) != list(_COLUMNS):
        raise InputError(f"{path}: columns are {shown(list(rows))}; allowed: {', '.join(_COLUMNS)}")
    for column in _COLUMNS:
        kind = _KINDS.get(column, "f")
        if rows[column].dtype.kind != kind or (
            kind == "O" and not all(isinstance(value, str) for value in rows[column])
        ):
            raise InputError(f"{path}: {column} holds other values than this program writes; {_REMEDY}")
    longest = rows["task"].map(lambda task: TASKS[task].episode_s if task in TASKS else _LONGEST_S)
    if not rows["score_s"].between(0.0, longest).all():
        raise InputError(f"{path}: score_s holds values outside of an episode; {_REMEDY}")
    return rows


def _of_agents(submitted: Submission, folder: Path, trust: bool) -> list[str]:
    """Faults of agents with other files than when they were played."""
    labels = [agent.agent for agent in submitted.agents]
    faults = [
        f"{score.agent}: has scores, but is no agent of the submission"
        for score in submitted.scores
        if score.agent not in labels
    ]
    submission.refuse_answers(submission.spec_of(agent, folder) for agent in submitted.agents)
    for agent in submitted.agents:
        if agent.copy_at is None and is_named(agent.spec) and not trust:
            raise InputError(
                f"{agent.agent} is the module {shown(agent.spec)}, which runs code; allowed if you trust it: --trust"
            )
        if submission.fingerprint_of(submission.spec_of(agent, folder)) != agent.fingerprint:
            faults.append(f"{agent.agent}: its files have changed since it was played")
    return faults


def _of_figures(submitted: Submission, rows: pd.DataFrame) -> list[str]:
    """Scores at odds with the patients' rows."""
    cells = by_cell(rows)
    named = {(score.task, score.agent) for score in submitted.scores}
    played = dict.fromkeys(zip(map(str, rows["task"]), map(str, rows["agent"]), strict=True))
    faults = [f"{task}, {agent}: patients without a score" for task, agent in played if (task, agent) not in named]
    for score in submitted.scores:
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
    numbers = sorted({score.patients for score in submitted.scores})
    if len(numbers) > 1 or numbers[0] == 1:
        faults.append(f"scores of {numbers[0]} to {numbers[-1]} patients; allowed: as many for each, 2 at least")
    return faults


def _same(one: SubmittedScore, other: SubmittedScore) -> bool:
    figures = [[score.score_s, score.low_s, score.high_s] for score in (one, other)]
    mine, theirs = (np.array([np.nan if value is None else value for value in row]) for row in figures)
    return one.patients == other.patients and bool(np.allclose(mine, theirs, rtol=_ROUNDING, atol=0.0, equal_nan=True))


def _of_entries(cells: Sequence[Cell], submitted: Submission) -> tuple[list[str], dict[tuple[str, str], float]]:
    """Faults of labels and notes; and the control step, s, by task and agent."""
    faults, steps = [], {}
    for cell, score in zip(cells, submitted.scores, strict=True):
        entry = cell.load()
        steps[score.task, score.agent] = 1.0 / mode_of(entry.env_kwargs).steps_per_s
        if not is_label_of(score.agent, entry.label):
            faults.append(f"{score.agent}: is the label of what calls itself {entry.label}")
        if score.note != entry.note:
            faults.append(f"{cell.name}: the note is {shown(score.note)}, the agent gives {shown(entry.note)}")
    return faults, steps


def drawn(parts: Sequence[Part], patients: int | None, draw: np.random.Generator) -> list[Part]:
    """The parts in which so many drawn patients lie; all of them where none are asked for."""
    if patients is None:
        return list(parts)
    places = len(parts) * PATIENTS_IN_A_PART
    numbers = draw.choice(places, min(patients, places), replace=False) // PATIENTS_IN_A_PART
    return [parts[number] for number in np.unique(numbers)]
