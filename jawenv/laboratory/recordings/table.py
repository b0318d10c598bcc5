"""A table of numbers with a few words about it, as a CSV or Parquet file: what a recording is kept as."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError, shown
from jawenv.files import atomic_write
from jawenv.reading import read_text

Array = NDArray[np.float64]

FORMATS = (".csv", ".parquet")
DIGITS = 12
LARGEST_RECORDING = 256 * 2**20
"""Bytes of a CSV file."""
_KEY = b"jawenv.record"


@dataclass(frozen=True)
class Table:
    """A file as read.

    Attributes:
        path: its name, for messages.
        columns: numbers by the columns' names; NaN where a cell is empty.
        lines: number that each row has in the file.
        about: what the file says about itself.
    """

    path: str
    columns: dict[str, Array]
    lines: NDArray[np.int64]
    about: dict[str, Any]

    def fail(self, column: str, row: int, value: str, allowed: str) -> InputError:
        """The error that names a cell."""
        return InputError(f"{self.path}: {column} in row {self.lines[row]} is {value}; allowed: {allowed}")


def checked_path(path: str | os.PathLike[str]) -> Path:
    """The path, if its ending is one of ``FORMATS``.

    Raises:
        InputError: it is not.
    """
    target = Path(path)
    if target.suffix not in FORMATS:
        raise InputError(f"{target}: the file's ending is {target.suffix!r}; allowed: {' or '.join(FORMATS)}")
    return target


def write_table(path: Path, columns: dict[str, Array], about: dict[str, Any]) -> None:
    """Write columns of one length, wholly or not at all; NaN becomes an empty cell.

    Raises:
        InputError: Parquet without pyarrow, or a file that cannot be written.
    """
    data = _csv(columns, about) if path.suffix == ".csv" else _parquet(columns, about)
    with atomic_write(path) as unfinished:
        unfinished.write_bytes(data)


def read_table(path: Path, known: Collection[str]) -> Table:
    """Read what ``write_table`` has written, or a table of one's own.

    Args:
        path: of the file.
        known: names that its words about itself may have; other comments of a CSV file are passed over.

    Raises:
        InputError: no file, no table, or a cell that is no number.
    """
    return _read_csv(path, known) if path.suffix == ".csv" else _read_parquet(path)


def _csv(columns: dict[str, Array], about: dict[str, Any]) -> bytes:
    text = io.StringIO(newline="")
    for name, value in about.items():
        text.write(f"# {name}: {json.dumps(value)}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow(["" if np.isnan(value) else f"{value:.{DIGITS}g}" for value in row])
    return text.getvalue().encode()


def _parquet(columns: dict[str, Array], about: dict[str, Any]) -> bytes:
    pa = _pyarrow()
    from jawenv.laboratory.recordings.parquet import write_parquet

    table = pa.table({name: pa.array(values, from_pandas=True) for name, values in columns.items()})
    table = table.replace_schema_metadata({_KEY: json.dumps(about).encode()})
    buffer = io.BytesIO()
    write_parquet(table, buffer)
    return buffer.getvalue()


def _pyarrow() -> Any:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise InputError("Parquet needs pyarrow (pip install pyarrow); allowed without it: a .csv file") from None
    return pyarrow


def _read_csv(path: Path, known: Collection[str]) -> Table:
    try:
        text = read_text(path, LARGEST_RECORDING, "utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path}: is no text; allowed: CSV in UTF-8") from None
    lines = text.splitlines()
    about: dict[str, Any] = {}
    first = 0
    for line in lines:
        if line.strip() and not line.startswith("#"):
            break
        first += 1
        name, _, value = line.lstrip("# ").partition(":")
        if name in known:
            try:
                about[name] = json.loads(value)
            except (ValueError, RecursionError):
                raise InputError(
                    f"{path}: {name} in row {first} is {shown(value.strip())}; allowed: JSON, as [1, 2]"
                ) from None
    try:
        rows = list(csv.reader(lines[first:]))
    except csv.Error as error:
        raise InputError(f"{path}: {error}; allowed: CSV") from None
    if len(rows) < 2:
        raise InputError(f"{path}: is empty; allowed: a row of column names and two or more rows of numbers")
    names = [name.strip() for name in rows[0]]
    filled_rows = [(first + 2 + i, row) for i, row in enumerate(rows[1:]) if any(cell.strip() for cell in row)]
    for line_number, row in filled_rows:
        if len(row) != len(names):
            raise InputError(f"{path}: row {line_number} has {len(row)} values; allowed: {len(names)}, one per column")
    if len(set(names)) < len(names):
        duplicate = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{path}: column {duplicate!r} stands there twice; allowed: once")
    columns = {
        name: np.array([_number(row[i], path, name, line) for line, row in filled_rows], dtype=np.float64)
        for i, name in enumerate(names)
    }
    return Table(str(path), columns, np.array([line for line, _ in filled_rows], dtype=np.int64), about)


def _number(text: str, path: Path, column: str, line: int) -> float:
    stripped = text.strip()
    if stripped == "":
        return float("nan")
    try:
        return float(stripped)
    except ValueError:
        allowed = "a number, or empty where nothing was read"
        raise InputError(f"{path}: {column} in row {line} is {shown(stripped)}; allowed: {allowed}") from None


def _read_parquet(path: Path) -> Table:
    pa = _pyarrow()
    from jawenv.laboratory.recordings.parquet import read_parquet

    try:
        table = read_parquet(path)
        about = json.loads((table.schema.metadata or {}).get(_KEY, b"{}"))
    except InputError:
        raise
    except (OSError, ValueError, pa.ArrowException) as error:
        raise InputError(f"{path}: {' '.join(str(error).split())[:120]}; allowed: a Parquet file") from None
    columns = {}
    for name in table.column_names:
        kind = table.schema.field(name).type
        if not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):
            raise InputError(f"{path}: column {name!r} is of type {kind}; allowed: numbers")
        columns[name] = table[name].to_numpy().astype(np.float64)
    return Table(str(path), columns, np.arange(1, table.num_rows + 1), about)
