"""Tasks on all cores, in processes that end at the task they are at when the run is interrupted."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import Any, TypeVar

Task = TypeVar("Task")
_stopped: Any = None  # of a worker process: set when the run is to end


def run_all(
    work: Callable[[Task], None], tasks: Sequence[Task], done: Callable[[Task], None], workers: int | None = None
) -> None:
    """Do every task, whose result ``work`` keeps by itself.

    Args:
        work: does one task; a function that processes can be sent.
        tasks: what there is to do.
        done: called with each finished task, in the order in which they finish.
        workers: processes; all cores by default. 1 works in this process.
    """
    count = min(workers or os.cpu_count() or 1, len(tasks))
    if count <= 1:
        for task in tasks:
            work(task)
            done(task)
    else:
        _in_processes(work, tasks, done, count)


def stopped() -> bool:
    """Whether the run is to end; a task that takes long asks now and then, and returns or raises without a result."""
    return _stopped is not None and _stopped.is_set()


def _in_processes(
    work: Callable[[Task], None], tasks: Sequence[Task], done: Callable[[Task], None], workers: int
) -> None:
    """Spawned processes, so that none inherits threads; each runs the kernels on one."""
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    before = {name: os.environ.get(name) for name in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS")}
    os.environ.update(dict.fromkeys(before, "1"))
    try:
        with ProcessPoolExecutor(workers, context, _begin_worker, (stop,)) as pool:
            running: dict[Future[None], Task] = {pool.submit(work, task): task for task in tasks}
            try:
                while running:
                    finished, _ = wait(running, return_when=FIRST_COMPLETED)
                    for future in finished:
                        task = running.pop(future)
                        future.result()
                        done(task)
            except BaseException:
                stop.set()
                pool.shutdown(cancel_futures=True)
                raise
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name)
            else:
                os.environ[name] = value


def _begin_worker(stop: Any) -> None:
    """Leave Ctrl-C to the parent, which then asks the workers to stop."""
    global _stopped
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _stopped = stop
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A parent that is killed cannot ask for anything: without it a worker would wait for tasks forever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
