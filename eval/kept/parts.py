"""Work in parts, on all cores, each kept on disk as soon as it is finished; kept parts are not done again.

What is made is the same from any number of processes, and however often a run was interrupted.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from joblib import Parallel, delayed
from rich.console import Console

from jawenv.base.errors import InputError, reason_of
from jawenv.base.locks import alone
from jawenv.base.progress import Progress

Content = TypeVar("Content")


@dataclass(frozen=True)
class Part:
    """Some items of a piece of work, and the file of their results."""

    key: str  # name of the piece of work
    first: int  # number of the first item
    number: int  # of items
    path: Path  # of the file, whose name changes with everything that could change its content


@dataclass(frozen=True)
class Run:
    """The way in which work is done."""

    fresh: bool = False  # do kept parts again
    workers: int | None = None  # processes; all cores by default. 1 works in this process
    console: Console | None = None  # where progress is shown; nowhere by default


def folder_for(output: Path, name: str) -> Path:
    """The folder of finished work in an output folder, made where it is missing."""
    folder = output / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"output {output}: {reason_of(error)}") from None
    return folder


def finish(
    parts: Sequence[Part],
    work: Callable[[Part, Progress], None],
    read: Callable[[Part], Content],
    unit: str,
    run: Run | None = None,
) -> list[Content]:
    """Read the kept file of every part, do the missing parts, and read theirs.

    An interrupt ends the processes at once: a file is on disk or not, and the next run makes the missing ones.

    Args:
        parts: all of the work.
        work: writes the file of a part, whole or not at all; a function that processes can be sent. The progress
            counts items, and is shown where one process works.
        read: from a part to the content of its file. Damage is found before anything is done.
        unit: name of the items, in the plural.
        run: how it is done.

    Returns:
        The content of each file.
    """
    run = run or Run()
    kept = {part.path: read(part) for part in parts if not run.fresh and part.path.exists()}
    missing = [part for part in parts if part.path not in kept]
    total, left = (sum(part.number for part in some) for some in (parts, missing))
    progress = Progress(total, unit, run.console or Console(quiet=True))
    with ExitStack() as locks, warnings.catch_warnings(), progress:
        for folder in sorted({part.path.parent for part in missing}):
            locks.enter_context(alone(folder))
        progress.say(f"making {total} {unit}")
        if left < total:
            progress.skip(total - left)
            progress.say(f"{total - left} of {total} {unit} kept from an earlier run")
        # A process that has compiled or loaded kernels is taken for one that leaks, and replaced: nothing is lost.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)
        _do(missing, work, run, progress)
    return [kept[part.path] if part.path in kept else read(part) for part in parts]


def _do(parts: Sequence[Part], work: Callable[[Part, Progress], None], run: Run, progress: Progress) -> None:
    """Do parts, and count each that ends."""
    parallel = _parallel(run, max(len(parts), 1))
    if parallel.n_jobs > 1:
        for part in parallel(delayed(_worked)(work, part) for part in parts):
            progress.advance_to(progress.done + part.number, part.key)
        return
    for part in parts:
        after = progress.done + part.number
        work(part, progress)
        progress.advance_to(after, part.key)


def _parallel(run: Run, most: int) -> Parallel:
    """Joblib's processes, at most as many as there are parts; one thread each: more would wait for each other."""
    count = min(run.workers or os.cpu_count() or 1, most)
    return Parallel(count, "loky", return_as="generator_unordered", batch_size=1, inner_max_num_threads=1)


def _worked(work: Callable[[Part, Progress], None], part: Part) -> Part:
    work(part, Progress(part.number, "items", Console(quiet=True)))
    return part
