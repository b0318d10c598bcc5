"""The tasks as cells of a study: every agent in every task that it fits, with public and with drawn patients."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from agents.registry import world_of
from eval.benchmark.tasks import PATIENTS_IN_A_PART, Task
from eval.kept.cells import Cell
from eval.kept.entries import can_play, load_entries, load_entry
from eval.rows.times import Times
from jawenv.base.errors import InputError

PUBLIC, DRAWN = "public", "drawn"
"""Patients of the tasks' own seeds, and as many whom a key draws."""


def cells_of(
    specs: Sequence[str], tasks: Sequence[Task], key: str, patients: int | None = None, *, trust: bool = False
) -> tuple[Cell, ...]:
    """Every agent in every task that it fits, twice; a trained one plays the tasks of its own environment.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own; one named twice counts once.
        tasks: at least one.
        key: draws the patients who are not the tasks' own.
        patients: the first ones of every task; all by default.
        trust: whether stable-baselines3 checkpoints may be unpickled.
    """
    if not specs:
        raise InputError("nothing to play: name a maneuver, a file, a training run or a policy")
    fitting = {spec: _fitting(spec, tasks) for spec in dict.fromkeys(specs)}
    labels = {
        task.id: {
            entry.spec: entry.label
            for entry in load_entries([s for s in fitting if task in fitting[s]], task.settings().world, trust=trust)
        }
        for task in tasks
    }
    return tuple(
        cell
        for spec, played in fitting.items()
        for task in played
        for cell in _pair(task, spec, labels[task.id][spec], key, task.seeds[:patients], trust)
    )


def _pair(task: Task, spec: str, agent: str, key: str, seeds: range, trust: bool) -> Iterator[Cell]:
    """One agent in one task, with public and with drawn patients."""
    load = partial(load_entry, spec, task.settings().world, trust=trust)
    times = Times(task.within, task.episode_s, task.comfort_limit_s)
    levels = {"task": task.id, "agent": agent}
    yield Cell(levels | {"patients": PUBLIC}, load, seeds, times, PATIENTS_IN_A_PART)
    drawn = replace(times, seeds=drawn_seeds(task.id, len(seeds), key))
    yield Cell(levels | {"patients": DRAWN}, load, range(len(seeds)), drawn, PATIENTS_IN_A_PART)


def drawn_seeds(task: str, number: int, key: str) -> tuple[int, ...]:
    """Seeds of a task's drawn patients, 63 bits of SHA-256 each: nobody knows them before the key."""
    digests = (hashlib.sha256(f"{key}|{task}|{patient}".encode()).digest() for patient in range(number))
    return tuple(int.from_bytes(digest[:8], "big") >> 1 for digest in digests)


def fitting_agents(specs: Sequence[str], tasks: Sequence[Task]) -> list[str]:
    """Agents that fit one of the tasks."""
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
