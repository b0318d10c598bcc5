"""Processes that tests start: each is killed in the end, with all that it started, and each wait has an end."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

LONGEST_S = 600.0


def python(*arguments: object, cwd: Any = None, env: Any = None, check: bool = True) -> Any:
    """What a new process of this Python did, which must end well unless ``check`` is False; ``env`` is added."""
    command = [sys.executable, *map(str, arguments)]
    given = {"cwd": cwd, "env": os.environ | (env or {}), "capture_output": True, "text": True, "timeout": LONGEST_S}
    ran = subprocess.run(command, **given)
    assert ran.returncode == 0 or not check, ran.stderr
    return ran


@contextmanager
def started(command: list[str], **options: Any) -> Iterator[subprocess.Popen[str]]:
    """Start a process in a session of its own, and kill the session whatever happens."""
    process = subprocess.Popen(command, text=True, start_new_session=True, **options)
    try:
        yield process
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait(30)
        for pipe in (process.stdin, process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()
