"""Work in chunks, on all cores, each kept on disk as soon as it is finished; what the disk holds is not done again."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from joblib import Parallel, delayed
from rich.console import Console

from jawenv.errors import InputError
from jawenv.locks import alone
from jawenv.progress import Progress

Backend = Literal["loky", "ray"]


@dataclass(frozen=True)
class Chunk:
    """Some items of a piece of work, and the files that keep what comes out.

    Attributes:
        key: what they are items of.
        first: number of the first item.
        number: of items.
        files: of each part of the work, by its name; a part may be done without the others. Their names change with
            whatever could change what they hold.
    """

    key: str
    first: int
    number: int
    files: tuple[tuple[str, Path], ...]


def folder_for(output: Path, name: str) -> Path:
    """The folder of finished work in an output folder, made where it is missing.

    Raises:
        InputError: it cannot be made.
    """
    folder = output / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"output {output}: {error.strerror}") from None
    return folder


def finish(
    chunks: Sequence[Chunk],
    work: Callable[[Chunk], None],
    unit: str,
    *,
    fresh: bool = False,
    workers: int | None = None,
    backend: Backend = "loky",
    console: Console | None = None,
) -> None:
    """Do what is missing of every chunk.

    An interrupt ends the processes at once: a file is on disk or not, and what is not is made by the next run.

    Args:
        chunks: all of the work.
        work: writes all files of a chunk, each whole or not at all; a function that processes can be sent.
        unit: what items are called, in the plural.
        fresh: do again what is on disk.
        workers: processes; all cores by default. 1 works in this process.
        backend: joblib's; "ray" works on the cores of a cluster, whose machines see the folder of the files.
        console: where progress is shown; nowhere by default.

    Raises:
        InputError: another process is at work in the same folder, the package of the backend is not installed, or the
            cluster cannot be reached.
    """
    missing = [replace(chunk, files=chunk.files if fresh else _missing_files(chunk)) for chunk in chunks]
    missing = [chunk for chunk in missing if chunk.files]
    total, left = _items(chunks), _items(missing)
    parallel = _parallel(backend, workers, max(len(missing), 1))
    progress = Progress(total, unit, console or Console(quiet=True))
    with ExitStack() as locks, warnings.catch_warnings(), progress:
        for folder in sorted({path.parent for chunk in missing for _, path in chunk.files}):
            locks.enter_context(alone(folder))
        progress.say(f"making {total} {unit}")
        if left < total:
            progress.skip(total - left)
            progress.say(f"{total - left} of {total} {unit} kept from an earlier run")
        # A process that has compiled or loaded kernels is taken for one that leaks, and replaced: nothing is lost.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given", UserWarning)
        for chunk in parallel(delayed(_worked)(work, chunk) for chunk in missing):
            progress.advance_to(progress.done + _items([chunk]), chunk.key)


def _parallel(backend: Backend, workers: int | None, most: int) -> Parallel:
    """Joblib's processes, at most as many as there are chunks; one thread each: more would wait for each other."""
    if backend == "ray":
        from eval.cluster import connect

        cores = connect(workers)
        count = min(workers or cores, cores, most)
        return Parallel(count, backend, "generator_unordered", batch_size=1, pre_dispatch=count)
    count = min(workers or os.cpu_count() or 1, most)
    return Parallel(count, backend, "generator_unordered", batch_size=1, inner_max_num_threads=1)


def _worked(work: Callable[[Chunk], None], chunk: Chunk) -> Chunk:
    work(chunk)
    return chunk


def _missing_files(chunk: Chunk) -> tuple[tuple[str, Path], ...]:
    return tuple((part, path) for part, path in chunk.files if not path.exists())


def _items(chunks: Sequence[Chunk]) -> int:
    return sum(chunk.number * len(chunk.files) for chunk in chunks)
