"""Outputs of a command: files beside its inputs, or JSON on the terminal."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

from jawenv.base.errors import InputError
from jawenv.base.files import check_kept, write_text

_TERMINAL = Path("-")


@dataclass(frozen=True)
class Output:
    """A file or the terminal, for an answer as JSON."""

    path: Path | None  # of the file; None for the terminal
    terminal: TextIO

    def write(self, answer: Mapping[str, Any]) -> None:
        """Write it; a file is named."""
        text = json.dumps(answer, indent=1) + "\n"
        if self.path is None:
            self.terminal.write(text)
        else:
            write_text(self.path, text)
            print(f"\nanswer: {self.path}")


@contextlib.contextmanager
def answering(path: Path | None) -> Iterator[Output | None]:
    """The answer of ``--json``; for ``-`` all else that the block prints goes to stderr."""
    if path is None:
        yield None
        return
    terminal, alone = sys.stdout, path == _TERMINAL
    with contextlib.redirect_stdout(sys.stderr if alone else terminal):
        yield Output(None if alone else path, terminal)


def check_outputs(page: Path | None, output: Output | None, inputs: Iterable[object]) -> None:
    """Check that page and answer are two files, and none of the inputs: options that are no file are passed over."""
    outputs = [path for path in (page, None if output is None else output.path) if path is not None]
    for path in outputs:
        check_kept(path, inputs)
    if len({path.resolve() for path in outputs}) < len(outputs):
        raise InputError(f"--page and --json are both {page}; allowed: two files")
