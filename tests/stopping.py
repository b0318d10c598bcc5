"""Commands that are stopped while they work, by a signal, and given again."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
ENVIRONMENT = os.environ | {
    "PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH")))),
    "OMP_NUM_THREADS": "1",
}


def stopped(
    command: Sequence[str], folder: Path, when: Callable[[], bool], by: signal.Signals = signal.SIGKILL
) -> tuple[int, str]:
    """Run ``python -m command`` in a folder and stop it, with the processes that it has made.

    Args:
        command: module and arguments.
        folder: in which it works.
        when: asked again and again: whether it shall be stopped now.
        by: the signal.

    Returns:
        Exit code and error output.
    """
    with subprocess.Popen(
        [sys.executable, "-m", *command],
        cwd=folder,
        env=ENVIRONMENT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        limit = time.monotonic() + 300.0  # for machines that are busy
        while process.poll() is None and not when() and time.monotonic() < limit:
            time.sleep(0.002)
        if process.poll() is None:
            os.killpg(process.pid, by)
        _, error = process.communicate(timeout=120)
        return process.returncode, error


def finished(command: Sequence[str], folder: Path) -> str:
    """Run ``python -m command`` in a folder to its end; its error output."""
    ran = subprocess.run(
        [sys.executable, "-m", *command], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stderr


def unfinished(folder: Path) -> list[Path]:
    """What was written by halves, and locks."""
    return [path for path in folder.rglob(".*") if path.name.endswith((".unfinished", ".new", ".old", ".lock"))]
