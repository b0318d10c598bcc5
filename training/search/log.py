"""What a search has found so far, in a text file from which the same search goes on after whatever stopped it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jawenv.errors import InputError, shown
from jawenv.files import write_text
from jawenv.reading import LARGEST_DATA, read_text


@dataclass(frozen=True)
class SearchLog:
    """A file whose first line names the settings of a search; each further one is a row of numbers.

    Args:
        path: of the file; made with the first row.
        settings: of the search, without what only says how long it is.
        numbers: in each row.
    """

    path: Path
    settings: Mapping[str, Any]
    numbers: int

    def rows(self) -> list[list[float]]:
        """The rows so far, to the bit as they were appended.

        A line that was being written when the search was stopped is taken out of the file.

        Raises:
            InputError: the file cannot be read, is damaged, or is of another search.
        """
        if not self.path.exists():
            return []
        try:
            text = read_text(self.path, LARGEST_DATA)
        except UnicodeDecodeError:
            raise InputError(f"{self.path} is damaged: it is no text; --overwrite begins anew") from None
        whole = text[: text.rfind("\n") + 1]
        head, *lines = whole.splitlines() or [self._head]
        if head != self._head or not (whole or self._head.startswith(text)):
            other = " ".join((whole or text).splitlines()[0].split())
            other = other if other.isprintable() and len(other) < 400 else shown(other)
            raise InputError(f"{self.path} is of another search ({other}); allowed: the same settings, or --overwrite")
        rows = [self._row(line, number) for number, line in enumerate(lines, start=2)]
        if whole != text:
            write_text(self.path, whole)
        return rows

    def append(self, row: Sequence[float]) -> None:
        """Add a row.

        Raises:
            InputError: the file cannot be written.
        """
        try:
            with self.path.open("a", encoding="utf-8") as file:
                head = "" if file.tell() else f"{self._head}\n"
                file.write(head + " ".join(f"{number:.17g}" for number in row) + "\n")
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror}") from None

    @property
    def _head(self) -> str:
        return f"# {dict(self.settings)}"

    def _row(self, line: str, number: int) -> list[float]:
        try:
            row = [float(text) for text in line.split()]
        except ValueError as error:
            reason = f"line {number}: {str(error)[:100]}"
            raise InputError(f"{self.path} is damaged: {reason}; --overwrite begins anew") from None
        if len(row) != self.numbers or not all(map(math.isfinite, row)):
            reason = f"line {number} has not {self.numbers} finite numbers"
            raise InputError(f"{self.path} is damaged: {reason}; --overwrite begins anew")
        return row
