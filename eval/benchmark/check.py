"""Whether a submission reproduces: its files, its figures, and its patients played again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

from agents.own import names_own
from eval.benchmark import differences, submission, tables
from eval.benchmark.patients import read_patients
from eval.benchmark.run import cell_of
from eval.benchmark.scores import by_cell
from eval.benchmark.submission import PAGE, PATIENTS, Submission, SubmittedAgent, SubmittedScore
from eval.benchmark.tasks import PATIENTS_IN_A_PART, TASKS
from eval.kept.cells import Cell, play_parts
from eval.kept.parts import Part, Run
from jawenv import versions
from jawenv.controls import mode_of
from jawenv.errors import InputError, shown
from jawenv.reading import read_text

_ROUNDING = 1e-9
CANNOT_KNOW = (
    "whether an agent was made for these patients, whose seeds are public",
    "whether a module reads or changes files and other processes of this machine, whose rights it has",
    "who made the submission, when, and on what: command, commit and machine are what it says",
)
"""What no check finds."""


@dataclass(frozen=True)
class Checked:
    """What a check has found.

    Attributes:
        played: how many episodes were played again.
        equal: how many of them have the same score to the digit.
        faults: what does not reproduce, a line each; none if all does.
        given: patients of each score; 0 where nothing was played.
        exact: whether every column was compared to the bit, on the platform that made them.
    """

    played: int
    equal: int
    faults: tuple[str, ...]
    given: int = 0
    exact: bool = False


def check(folder: Path, patients: int | None = None, run: Run | None = None, *, trust: bool = False) -> Checked:
    """Play a submission again.

    On the platform that made it every column is compared to the bit. On another one, which rounds otherwise, times
    may differ by a control step and other columns by a tenth, unless the differences lean one way.

    Args:
        folder: of the submission.
        patients: of each task and agent so many, drawn by entropy of this machine's; with each the part is played in
            which it lies. All by default.
        run: how it is played.
        trust: whether modules that the submission names may be run, and checkpoints unpickled.

    Raises:
        InputError: a file is missing or damaged, is of other tasks, or needs trust.
    """
    given = submission.read(folder)
    rows = read_patients(folder / PATIENTS, given.made_with)
    faults = [*_of_agents(given, folder, trust), *_of_figures(given, rows)]
    if not faults and read_text(folder / PAGE) != tables.markdown(rows, given.made_with):
        faults = [f"{PAGE}: is not the page of these patients"]
    if faults:
        return Checked(0, 0, tuple(faults))
    cells = [_cell(score, given, folder, trust) for score in given.scores]
    faults, steps = _of_entries(cells, given)
    if faults:
        return Checked(0, 0, tuple(faults))
    with TemporaryDirectory() as place:
        draw = np.random.default_rng()
        parts: list[tuple[Cell, Part]] = []
        for cell in cells:
            parts += [(cell, part) for part in drawn(cell.parts(Path(place)), patients, draw)]
        again = play_parts(parts, run)
    exact = _platform(given.made_with) == _platform(versions.made_with())
    faults = differences.faults_of(rows, again, None if exact else steps)
    both = again.merge(rows, on=differences.KEYS, suffixes=("", "_given"))
    equal = int((both["score_s"] == both["score_s_given"]).sum())
    return Checked(len(again), equal, tuple(faults), given.scores[0].patients, exact)


def _platform(made_with: Mapping[str, Any]) -> list[Any]:
    machine = made_with["machine"]
    return [machine["processor"], machine["system"], made_with["versions"]]


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
    played = dict.fromkeys(zip(map(str, rows["task"]), map(str, rows["agent"]), strict=True))
    faults = [f"{task}, {agent}: patients without a score" for task, agent in played if (task, agent) not in named]
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
    numbers = sorted({score.patients for score in given.scores})
    if len(numbers) > 1 or numbers[0] == 1:
        faults.append(f"scores of {numbers[0]} to {numbers[-1]} patients; allowed: as many for each, 2 at least")
    return faults


def _same(one: SubmittedScore, other: SubmittedScore) -> bool:
    figures = [[score.score_s, score.low_s, score.high_s] for score in (one, other)]
    mine, theirs = (np.array([np.nan if value is None else value for value in each]) for each in figures)
    return one.patients == other.patients and bool(np.allclose(mine, theirs, rtol=_ROUNDING, atol=0.0, equal_nan=True))


def _of_entries(cells: Sequence[Cell], given: Submission) -> tuple[list[str], dict[tuple[str, str], float]]:
    """Labels and notes that are not those of the agents; and the control step, s, by task and agent."""
    specs = {each.agent: each.spec for each in given.agents}
    faults, steps = [], {}
    for cell, score in zip(cells, given.scores, strict=True):
        entry = cell.load()
        steps[score.task, score.agent] = 1.0 / mode_of(entry.env_kwargs).steps_per_s
        if score.agent not in (entry.label, f"{entry.label} ({specs[score.agent]})"):
            faults.append(f"{score.agent}: is the label of what calls itself {entry.label}")
        if score.note != entry.note:
            faults.append(f"{cell.name}: the note is {shown(score.note)}, the agent gives {shown(entry.note)}")
    return faults, steps


def _cell(score: SubmittedScore, given: Submission, folder: Path, trust: bool) -> Cell:
    agent = next(each for each in given.agents if each.agent == score.agent)
    return cell_of(TASKS[score.task], _spec(agent, folder), score.agent, score.patients, trust=trust)


def _spec(agent: SubmittedAgent, folder: Path) -> str:
    return agent.spec if agent.copy_at is None else str(folder / agent.copy_at)


def drawn(parts: Sequence[Part], patients: int | None, draw: np.random.Generator) -> list[Part]:
    """The parts in which so many drawn patients lie; all of them where none are asked for."""
    if patients is None:
        return list(parts)
    places = len(parts) * PATIENTS_IN_A_PART
    found = draw.choice(places, min(patients, places), replace=False) // PATIENTS_IN_A_PART
    return [parts[place] for place in np.unique(found)]
