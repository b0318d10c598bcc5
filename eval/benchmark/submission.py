"""A submission: a folder with scores, patients, and the agents' files, so that anyone can play it again.

::

    FOLDER/submission.json     versions, digest of the tasks, agents with their fingerprints, scores
           benchmark.md        the scores as tables
           benchmark.parquet   one row per task, agent and patient
           agents/             files of the agents that do not come with jawenv
           parts/              finished parts, to go on after an interrupt
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import shutil
import uuid
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Self

import pandas as pd
from pydantic import AfterValidator, Field, JsonValue, model_validator

from agents import registry
from agents.planners import PLANNERS
from agents.replay import Replay
from eval.benchmark.labels import Label, Text, printable
from eval.benchmark.run import cell_of
from eval.benchmark.scores import by_cell, score_of
from eval.benchmark.tasks import TASKS, VERSION, digest
from eval.kept.cells import Cell
from jawenv.base.errors import InputError, shown
from jawenv.base.files import InputModel, Number, atomic_write, read_model
from jawenv.base.named_objects import is_named
from jawenv.base.reading import read_bytes
from jawenv.playing.excitation import EXCITATIONS
from jawenv.playing.policies.card import card_of, policy_names

FILE, PATIENTS, PAGE, AGENTS = "submission.json", "benchmark.parquet", "benchmark.md", "agents"


_MOST_AGENTS = 200


class _MadeWith(InputModel):
    command: Text
    versions: dict[Text, Text]
    git: dict[str, Text | bool] | None
    machine: dict[str, Text | int | None]
    finished: Text

    @model_validator(mode="after")
    def _has_all(self) -> Self:
        for field, names in (("versions", ("jawenv",)), ("git", ("commit", "changed")), ("machine", _MACHINE)):
            held = getattr(self, field)
            missing = [name for name in names if held is not None and name not in held]
            if missing:
                raise ValueError(f"{field}: lacks '{missing[0]}'")
        return self


_MACHINE = ("processor", "cores", "system")


def _made(content: dict[str, Any]) -> dict[str, Any]:
    _MadeWith.model_validate(content)
    return content


class SubmittedAgent(InputModel):
    """The agent of some scores."""

    agent: Label  # its label
    spec: Text  # as typed
    copy_at: Text | None = None
    """Where the folder of the submission holds it, from there; None if it comes with jawenv, or is a module."""
    fingerprint: Text | None = None  # SHA-256 of its files' names and contents; None if it has none


class SubmittedScore(InputModel):
    """The score of one agent in one task."""

    task: Text  # its id
    agent: Label  # label of the agent
    patients: Annotated[int, Field(ge=1, strict=True)]  # how many, from the first one on
    score_s: Number  # the score, s
    low_s: Number | None  # lower end of its 95 % interval; None of one patient
    high_s: Number | None  # its upper end
    note: Annotated[str, AfterValidator(printable)] = ""
    """In which settings the agent differs from the task's; empty if in none."""


class Submission(InputModel):
    """All that ``submission.json`` holds."""

    benchmark: Text  # version of the tasks
    tasks_digest: Text  # of all that makes them
    agents: Annotated[tuple[SubmittedAgent, ...], Field(min_length=1, max_length=_MOST_AGENTS)]  # who was played
    scores: Annotated[tuple[SubmittedScore, ...], Field(min_length=1, max_length=_MOST_AGENTS * len(TASKS))]
    """Of each task and agent."""
    made_with: Annotated[dict[str, JsonValue], AfterValidator(_made)]  # command, versions, commit, machine and time

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        scores = [f"{score.task}, {score.agent}" for score in self.scores]
        agents = [agent.agent for agent in self.agents]
        for kind, named in (("scores", scores), ("agents", agents)):
            twice = [name for name, number in Counter(named).items() if number > 1]
            if twice:
                raise ValueError(f"{kind}: '{twice[0]}' is there twice; allowed: once")
        return self


def read(folder: Path) -> Submission:
    """Read ``submission.json`` of a folder."""
    submission = read_model(folder / FILE, Submission)
    if (submission.benchmark, submission.tasks_digest) != (VERSION, digest()):
        raise InputError(
            f"{folder / FILE}: is of tasks {shown(submission.benchmark)}, digest {shown(submission.tasks_digest)}; "
            f"this jawenv plays {VERSION}, digest {digest()}"
        )
    for score in submission.scores:
        check_times(folder / FILE, score.task, (score.score_s, score.low_s, score.high_s))
    for agent in submission.agents:
        _check_origin(agent, folder / FILE)
    return submission


def check_times(file: Path, task: str, times: Iterable[float | None]) -> None:
    """Make sure that times lie within the task's episode; tasks of another version are not known."""
    longest = TASKS[task].episode_s if task in TASKS else math.inf
    for time in times:
        if time is not None and not 0.0 <= time <= longest:
            raise InputError(f"{file}: {task}: a score is {time:g} s; allowed: 0 to {longest:g}")


def make(
    cells: Sequence[Cell], rows: pd.DataFrame, agents: Sequence[SubmittedAgent], metadata: dict[str, Any]
) -> Submission:
    """The submission of played cells.

    Args:
        cells: the played cells.
        rows: of `eval.kept.cells.play_cells`.
        agents: of `keep_agents`.
        metadata: of `eval.kept.tables.made_with`.
    """
    notes = {tuple(cell.levels.values()): cell.load().note for cell in cells}
    scores = tuple(scored(task, agent, of_cell, notes[task, agent]) for (task, agent), of_cell in by_cell(rows).items())
    return Submission(
        benchmark=VERSION, tasks_digest=digest(), agents=tuple(agents), scores=scores, made_with=_json_of(metadata)
    )


def scored(task: str, agent: str, rows: pd.DataFrame, note: str = "") -> SubmittedScore:
    """The score of the patients' rows of one cell."""
    score = score_of(rows)
    low, high = (score.low, score.high) if score.known else (None, None)
    return SubmittedScore(
        task=task, agent=agent, patients=len(rows), score_s=score.value, low_s=low, high_s=high, note=note
    )


def cell_of_score(score: SubmittedScore, submitted: Submission, folder: Path, *, trust: bool = False) -> Cell:
    """The cell by which a score is played again."""
    agent = next(candidate for candidate in submitted.agents if candidate.agent == score.agent)
    return cell_of(TASKS[score.task], spec_of(agent, folder), score.agent, score.patients, trust=trust)


def spec_of(agent: SubmittedAgent, folder: Path) -> str:
    """The name or path that loads a submitted agent."""
    return agent.spec if agent.copy_at is None else str(folder / agent.copy_at)


def _json_of(metadata: dict[str, Any]) -> dict[str, Any]:
    """A mapping after a way through JSON: lists for tuples, texts for keys."""
    plain: dict[str, Any] = json.loads(json.dumps(metadata))
    return plain


def keep_agents(agents: Mapping[str, str], folder: Path) -> tuple[SubmittedAgent, ...]:
    """Copy the files of every agent of one's own into the folder.

    A module of one's own is not copied: whoever checks the submission has it importable.

    Args:
        agents: label -> name, file or module.
        folder: of the submission; its ``agents`` are replaced when all copies are written.
    """
    for left in folder.glob(f".{AGENTS}.*"):  # of a process that was killed
        _remove(left)
    beside = folder / f".{AGENTS}.{uuid.uuid4().hex}"
    submitted = []
    try:
        for number, (agent, spec) in enumerate(agents.items()):
            copies = _comes_with_jawenv(spec) or is_named(spec)
            copy_at = None if copies else _copied(spec, beside, number)
            held = spec if copy_at is None else str(beside / copy_at)
            submitted.append(SubmittedAgent(agent=agent, spec=spec, copy_at=copy_at, fingerprint=fingerprint_of(held)))
        old = beside / "old"
        with _writing(folder):
            beside.mkdir(parents=True, exist_ok=True)
            if os.path.lexists(folder / AGENTS):
                (folder / AGENTS).replace(old)
            if (beside / AGENTS).exists():
                (beside / AGENTS).replace(folder / AGENTS)
    finally:
        _remove(beside)
    return tuple(submitted)


def _remove(path: Path) -> None:
    if path.is_symlink() or path.is_file():
        path.unlink()
    else:
        shutil.rmtree(path, ignore_errors=True)


@contextlib.contextmanager
def _writing(folder: Path) -> Iterator[None]:
    """Fail to write in one line."""
    try:
        yield
    except OSError as error:
        raise InputError(f"output {folder}: {error.strerror}") from None


def refuse_copies(specs: Iterable[str], folder: Path) -> None:
    """Make sure that no agent lies where a submission is written."""
    for spec in specs:
        if not is_named(spec) and _real(spec).is_relative_to(_real(folder / AGENTS)):
            raise InputError(f"{spec} lies in the output's own {AGENTS}, which is written anew: name another output")


def refuse_answers(specs: Iterable[str]) -> None:
    """Make sure that recorded actions are one sequence for all patients."""
    for spec in specs:
        if Path(spec).suffix == ".npz" and (number := Replay.load(Path(spec)).number) > 1:
            raise InputError(
                f"{spec}: holds {number} sequences of actions; allowed in the benchmark: one for all patients"
            )


def fingerprint_of(spec: str) -> str | None:
    """SHA-256 of the names and contents of an agent's files; None if it has none."""
    files = registry.files_of(spec)
    if not files:
        return None
    content = hashlib.sha256()
    for file in sorted(files, key=lambda path: path.name):
        content.update(file.name.encode() + hashlib.sha256(read_bytes(file)).digest())
    return content.hexdigest()


def _real(path: str | Path) -> Path:
    return Path(os.path.realpath(path))  # `Path.resolve` raises where a link leads to itself


def _comes_with_jawenv(spec: str) -> bool:
    return spec in (*registry.names(), *policy_names(), *EXCITATIONS, *PLANNERS)


def _copied(spec: str, folder: Path, number: int) -> str:
    """Copy the files of a spec below ``agents/NUMBER``, as they lie together.

    Returns:
        Path of the copy from the folder on.
    """
    path, files = _real(spec), registry.files_of(spec)
    run = card_of(path)
    root = path if path.is_dir() else path.parent if run is None else _real(run[0])
    copy = PurePosixPath(AGENTS, str(number), root.name or "root")
    for file in map(_real, files):
        target = folder / copy / file.relative_to(root).as_posix()
        with _writing(folder.parent):
            target.parent.mkdir(parents=True, exist_ok=True)
        content = read_bytes(file)
        with atomic_write(target) as unfinished:
            unfinished.write_bytes(content)
    return str(copy if path == root else copy / path.relative_to(root).as_posix())


def _check_origin(agent: SubmittedAgent, file: Path) -> None:
    """A submission names copies in its folder, agents of jawenv, and modules; nothing else on this machine."""
    if agent.copy_at is None:
        if not (_comes_with_jawenv(agent.spec) or is_named(agent.spec)):
            raise InputError(f"{file}: agent {shown(agent.spec)} is none of jawenv's, and the folder has no copy of it")
        return
    copy_at = PurePosixPath(agent.copy_at)
    inside = _real(file.parent / copy_at).is_relative_to(_real(file.parent) / AGENTS)
    if copy_at.parts[:1] != (AGENTS,) or ".." in copy_at.parts or "\\" in agent.copy_at or not inside:
        raise InputError(f"{file}: copy_at is {shown(agent.copy_at)}; allowed: a path within {AGENTS}/")
