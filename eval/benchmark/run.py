"""Playing the tasks: some patients of one task and agent are a part, which is kept once it is finished."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import pandas as pd

from agents.registry import world_of
from eval.benchmark import times
from eval.benchmark.agent_process import load_apart
from eval.benchmark.tasks import PATIENTS_IN_A_PART, Task
from eval.benchmark.times import COLUMNS, rows_of
from eval.comparison import results
from eval.entries import Entry, fits, load_entries
from eval.kept.digest import fingerprint
from eval.kept.parts import Part, Run, finish, folder_for, parts_of
from eval.kept.tables import read_table, write_table
from jawenv.errors import InputError
from jawenv.progress import Progress


@dataclass(frozen=True)
class Cell:
    """One agent in one task.

    Attributes:
        task: the task.
        agent: label of the agent.
        spec: what the agent is loaded by.
        note: in which settings it differs from the task's; empty if in none.
        trust: whether its checkpoint may be unpickled.
    """

    task: Task
    agent: str
    spec: str
    note: str = ""
    trust: bool = False

    @property
    def name(self) -> str:
        """What tells it apart."""
        return f"{self.task.id} · {self.agent}"

    def load(self) -> Entry:
        """The agent, ready to be played."""
        settings = self.task.settings()
        return load_entries([self.spec], settings.world, trust=self.trust, load=load_apart)[0]


def cells_of(specs: Sequence[str], tasks: Sequence[Task], *, trust: bool = False) -> tuple[Cell, ...]:
    """Every agent in every task that it fits; one that was trained in an environment plays the tasks of that one.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own; one named twice counts once.
        tasks: at least one.
        trust: whether checkpoints that lie in no run's folder may be unpickled.

    Raises:
        InputError: no agent, one that cannot be loaded, or one that fits no task.
    """
    if not specs:
        raise InputError("nothing to play: name a maneuver, a file, a training run or a policy")
    found = [cell for spec in dict.fromkeys(specs) for cell in _cells_of_one(spec, tasks, trust)]
    specs_of: dict[str, set[str]] = {}
    for cell in found:
        specs_of.setdefault(cell.agent, set()).add(cell.spec)
    return tuple(
        cell if len(specs_of[cell.agent]) == 1 else replace(cell, agent=f"{cell.agent} ({cell.spec})") for cell in found
    )


def _cells_of_one(spec: str, tasks: Sequence[Task], trust: bool) -> list[Cell]:
    trained_in = world_of(spec)
    fitting = [task for task in tasks if trained_in is None or fits(trained_in.env_id, task.settings().world.env_id)]
    if trained_in is not None and not fitting:
        raise InputError(f"{spec} was trained in {trained_in.env_id}, where none of these tasks is played")
    cells = []
    for task in fitting:
        cell = Cell(task, "", spec, trust=trust)
        entry = cell.load()
        cells.append(replace(cell, agent=entry.label, note=entry.note))
    return cells


def play_cells(
    cells: Iterable[Cell], output: Path, patients: int | None = None, run: Run | None = None
) -> pd.DataFrame:
    """Play the first patients of every cell.

    Args:
        cells: of `cells_of`.
        output: folder; its ``parts`` holds what is finished.
        patients: of every task; all by default.
        run: how it is played.

    Returns:
        One row per cell and patient: task, agent and `COLUMNS`.

    Raises:
        InputError: an output folder that cannot be used, or a kept file that is damaged.
    """
    folder = folder_for(output, "parts")
    return play_parts([(cell, part) for cell in cells for part in parts_of_cell(cell, folder, patients)], run)


def parts_of_cell(cell: Cell, folder: Path, patients: int | None = None) -> list[Part]:
    """The parts of the first patients of a cell.

    Raises:
        InputError: a file of the agent cannot be read.
    """
    # What the task says in words decides nothing.
    settings = cell.task.settings().of_a_patient() | {"within": cell.task.within, "agent": cell.agent}
    made = {f"{cell.task.id}-{cell.agent}": fingerprint(cell.load(), settings, results, times)}
    seeds = cell.task.seeds[:patients]
    return parts_of(cell.name, seeds, PATIENTS_IN_A_PART, folder, made)


def play_parts(parts: Sequence[tuple[Cell, Part]], run: Run | None = None) -> pd.DataFrame:
    """Play parts, but for those that are kept.

    Returns:
        One row per patient: task, agent and `COLUMNS`.

    Raises:
        InputError: a kept file is damaged, or another process is at work in the folder.
    """
    cells = {cell.name: cell for cell, _ in parts}
    kept = finish([part for _, part in parts], partial(play_part, cells=cells), _read, "episodes", run)
    return pd.concat([_placed(kept[path], cell) for cell, part in parts for _, path in part.files], ignore_index=True)


def play_part(part: Part, progress: Progress, cells: Mapping[str, Cell]) -> None:
    """Play some patients of one cell and keep their rows.

    Args:
        part: ``first`` is the seed of the first patient.
        progress: counts episodes.
        cells: by their names.
    """
    cell = cells[part.key]
    entry = cell.load()
    recording = entry.play(part.number, part.first, track_bound=False)
    rows = rows_of(recording, part.first, cell.task.within, cell.task.episode_s)
    for _, path in part.files:
        write_table(rows, path, {"task": asdict(cell.task)})


def _read(path: Path) -> pd.DataFrame:
    return read_table(path, COLUMNS)[0]


def _placed(rows: pd.DataFrame, cell: Cell) -> pd.DataFrame:
    rows = rows.copy()
    rows.insert(0, "task", cell.task.id)
    rows.insert(1, "agent", cell.agent)
    return rows
