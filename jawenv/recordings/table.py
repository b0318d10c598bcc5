"""A table of numbers with a few words about it, as a CSV or Parquet file: what a recording is kept as."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown
from jawenv.base.files import atomic_write
from jawenv.recordings.dialects import decimal_signs, grouped, number, read_sheet

Array = NDArray[np.float64]

FORMATS = (".csv", ".parquet")
DIGITS = 12
LARGEST_RECORDING = 256 * 2**20
"""Bytes of a CSV file."""
_KEY = b"jawenv.record"


@dataclass(frozen=True)
class RecordTable:
    """A file as read."""

    path: str  # its name, for messages
    columns: dict[str, Array]  # numbers by the columns' names; NaN where a cell is empty
    lines: NDArray[np.int64]  # number that each row has in the file
    header: dict[str, Any]  # what the file says about itself
    units: dict[str, str] = field(default_factory=dict)  # what a row of units says, by the columns' names

    def fail(self, column: str, row: int, value: str, allowed: str) -> InputError:
        """The error that names a cell."""
        return InputError(f"{self.path}: {column} in row {self.lines[row]} is {value}; allowed: {allowed}")


def checked_path(path: str | os.PathLike[str]) -> Path:
    """The path, if its ending is one of ``FORMATS``."""
    target = Path(path)
    if target.suffix not in FORMATS:
        raise InputError(f"{target}: the file's ending is {target.suffix!r}; allowed: {' or '.join(FORMATS)}")
    return target


def write_table(path: Path, columns: dict[str, Array], header: dict[str, Any]) -> None:
    """Write columns of one length, wholly or not at all; NaN becomes an empty cell."""
    data = _csv(columns, header) if path.suffix == ".csv" else _parquet(columns, header)
    with atomic_write(path) as unfinished:
        unfinished.write_bytes(data)


def read_table(path: Path, words: Collection[str]) -> RecordTable:
    """Read what ``write_table`` has written, or a table of one's own.

    Args:
        path: of the file.
        words: names that its words about itself may have; other comments of a CSV file are passed over.
    """
    return _read_csv(path, words) if path.suffix == ".csv" else _read_parquet(path)


def _csv(columns: dict[str, Array], header: dict[str, Any]) -> bytes:
    text = io.StringIO(newline="")
    for name, value in header.items():
        text.write(f"# {name}: {json.dumps(value)}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow(["" if np.isnan(value) else f"{value:.{DIGITS}g}" for value in row])
    return text.getvalue().encode()


def _parquet(columns: dict[str, Array], header: dict[str, Any]) -> bytes:
    pa = _pyarrow()
    from jawenv.recordings.parquet import write_parquet

    table = pa.table({name: pa.array(values, from_pandas=True) for name, values in columns.items()})
    table = table.replace_schema_metadata({_KEY: json.dumps(header).encode()})
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


def _read_csv(path: Path, words: Collection[str]) -> RecordTable:
    sheet = read_sheet(path, LARGEST_RECORDING)
    header: dict[str, Any] = {}
    for line, comment in sheet.comments:
        name, _, value = comment.lstrip("#%/ ").partition(":")
        if name in words:
            try:
                header[name] = json.loads(value)
            except (ValueError, RecursionError):
                raise InputError(
                    f"{path}: {name} in row {line} is {shown(value.strip())}; allowed: JSON, as [1, 2]"
                ) from None
    if len(decimal_signs(sheet.rows)) > 1:
        raise InputError(f"{path}: has decimal points and decimal commas; allowed: one of the two")
    if grouped(list(zip(*sheet.rows, strict=True))):
        raise InputError(f"{path}: has numbers as 1,234 alone; allowed: numbers without separators of thousands")
    columns = {}
    for i, name in enumerate(sheet.names):
        numbers = [number(row[i]) for row in sheet.rows]
        if None in numbers:
            bad, allowed = numbers.index(None), "a number, or empty where nothing was read"
            value = shown(sheet.rows[bad][i])
            raise InputError(f"{path}: {shown(name)[1:-1]} in row {sheet.lines[bad]} is {value}; allowed: {allowed}")
        columns[name] = np.array(numbers, dtype=np.float64)
    units = dict(zip(sheet.names, sheet.units, strict=False))
    return RecordTable(str(path), columns, np.array(sheet.lines, dtype=np.int64), header, units)


def _read_parquet(path: Path) -> RecordTable:
    pa = _pyarrow()
    from jawenv.recordings.parquet import read_parquet

    try:
        table = read_parquet(path)
        header = json.loads((table.schema.metadata or {}).get(_KEY, b"{}"))
        of_pandas = (table.schema.pandas_metadata or {}).get("columns", [])
        categories = {column["name"] for column in of_pandas if column["pandas_type"] == "categorical"}
    except InputError:
        raise
    except (OSError, ValueError, TypeError, KeyError, AttributeError, pa.ArrowException) as error:
        raise InputError(f"{path}: {' '.join(str(error).split())[:120]}; allowed: a Parquet file") from None
    columns = {}
    for name in table.column_names:
        kind = table.schema.field(name).type
        if name in categories or not (pa.types.is_floating(kind) or pa.types.is_integer(kind)):
            kind = "category" if name in categories else kind
            raise InputError(f"{path}: column {shown(name)} is of type {kind}; allowed: numbers")
        columns[name] = table[name].to_numpy().astype(np.float64)
    return RecordTable(str(path), columns, np.arange(1, table.num_rows + 1), header)
