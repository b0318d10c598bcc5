"""The one-line error of a command without the packages of its group; it imports nothing that has to be installed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper

OWN = ("jawenv", "agents", "training", "eval")


@contextmanager
def installed(command: str, group: str) -> Iterator[None]:
    """Around a command: where a package is missing, one line says how to install it, and the exit code is 2.

    A terminal without Unicode shows a question mark for each character beyond its encoding.

    Args:
        command: as the message names it.
        group: of the clone's requirements, with all that the command needs.

    Raises:
        ModuleNotFoundError: a module of the project itself is missing.
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").split(".")[0]
        if not package or package in OWN:
            raise
        print(f"error: {command} needs {package}: .ci/setup {group}", file=sys.stderr)
        raise SystemExit(2) from None
