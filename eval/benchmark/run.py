"""The tasks as cells of a study: every agent in every task that it fits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from agents.registry import world_of
from eval.benchmark.tasks import PATIENTS_IN_A_PART, Task
from eval.kept.cells import Cell
from eval.kept.entries import can_play, load_entry
from eval.rows.times import Times
from jawenv.base.errors import InputError


def cells_of(
    specs: Sequence[str], tasks: Sequence[Task], patients: int | None = None, *, trust: bool = False
) -> tuple[Cell, ...]:
    """Every agent in every task that it fits; a trained one plays the tasks of its own environment.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own; one named twice counts once.
        tasks: at least one.
        patients: the first ones of every task; all by default.
        trust: whether stable-baselines3 checkpoints may be unpickled.
    """
    if not specs:
        raise InputError("nothing to play: name a maneuver, a file, a training run or a policy")
    cells = [
        (spec, cell_of(task, spec, patients=patients, trust=trust))
        for spec in dict.fromkeys(specs)
        for task in _fitting(spec, tasks)
    ]
    named: dict[object, set[str]] = {}
    for spec, cell in cells:
        named.setdefault(cell.levels["agent"], set()).add(spec)
    return tuple(
        cell
        if len(named[cell.levels["agent"]]) == 1
        else replace(cell, levels={**cell.levels, "agent": f"{cell.levels['agent']} ({spec})"})
        for spec, cell in cells
    )


def cell_of(task: Task, spec: str, agent: str = "", patients: int | None = None, *, trust: bool = False) -> Cell:
    """One agent in one task.

    Args:
        task: the task.
        spec: name, file or module of the agent.
        agent: how the table calls it; by its own label by default.
        patients: the first ones; all by default.
        trust: whether a stable-baselines3 checkpoint may be unpickled.
    """
    load = partial(load_entry, spec, task.settings().world, trust=trust)
    levels = {"task": task.id, "agent": agent or load().label}
    return Cell(
        levels,
        load,
        task.seeds[:patients],
        times_of(task),
        PATIENTS_IN_A_PART,
    )


def times_of(task: Task) -> Times:
    """The columns of a task's patients."""
    return Times(task.within, task.episode_s, task.comfort_limit_s)


def fitting_agents(specs: Sequence[str], tasks: Sequence[Task]) -> list[str]:
    """Those that fit one of the tasks."""
    return [spec for spec in specs if any(can_play(spec, task.settings().world) for task in tasks)]


def _fitting(spec: str, tasks: Sequence[Task]) -> list[Task]:
    fitting = [task for task in tasks if can_play(spec, task.settings().world)]
    if not fitting:
        trained_in = world_of(spec)
        trained = None if trained_in is None else f"was trained in {trained_in.env_id}, not in"
        why = trained or "plans in another environment than"
        raise InputError(f"{spec} {why} that of these tasks: {', '.join(task.id for task in tasks)}")
    return fitting


def left_out(cells: Sequence[Cell], tasks: Sequence[Task]) -> Iterator[str]:
    """A line for each agent that some task leaves out."""
    played: dict[str, set[object]] = {}
    for cell in cells:
        played.setdefault(str(cell.levels["agent"]), set()).add(cell.levels["task"])
    for agent, ids in played.items():
        if missing := [task.id for task in tasks if task.id not in ids]:
            yield f"{agent} is for other environments than: {', '.join(missing)}"
