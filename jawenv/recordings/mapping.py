"""A file's own column names and units, as a mapping file says which column of the project each is."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from jawenv.base.errors import InputError, meant, shown
from jawenv.base.files import InputModel, read_mapping, validate
from jawenv.recordings.columns import DEG, ENCODERS, READINGS, SAMPLES, TIME
from jawenv.recordings.table import RecordTable

NAMES = (TIME, *(column.name for column in (*ENCODERS, *READINGS, *SAMPLES)))
_ENDINGS = {"_mm_s": "mm/s", "_deg_s": "deg/s", "_N_m": "N m", "_mm": "mm", "_deg": "deg", "_N": "N", "_s": "s"}
_GRAM = 9.80665e-3
UNITS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "mm": {"mm": 1.0, "um": 1e-3, "cm": 10.0, "m": 1e3},
    "deg": {"deg": 1.0, "rad": DEG, "mrad": DEG / 1e3},
    "mm/s": {"mm/s": 1.0, "cm/s": 10.0, "m/s": 1e3},
    "deg/s": {"deg/s": 1.0, "rad/s": DEG, "mrad/s": DEG / 1e3},
    "N": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "gf": _GRAM, "kgf": 1e3 * _GRAM},
    "N m": {"N m": 1.0, "N cm": 1e-2, "N mm": 1e-3, "mN m": 1e-3, "kgf m": 1e3 * _GRAM, "gf cm": 1e-2 * _GRAM},
}
"""Other units in the unit of a column, by the latter."""


class Source(InputModel):
    """The file's column from which one of the project's comes."""

    name: str  # of the file's column
    unit: str | None = None  # of its numbers; by default the project's
    sign: Literal[1, -1] = 1  # -1 where its axis points the other way


def read_columns(path: Path, names: Sequence[str] = NAMES) -> dict[str, Source]:
    """Read a mapping file: for each column of the project, one of ``names``, its name, unit and sign in the file."""
    data: Mapping[str, Any] = read_mapping(path)
    for name in data:
        if name not in names:
            raise InputError(
                f"{path}: column is {shown(name)}; {meant(str(name), names)}allowed: {', '.join(names[:25])}"
            )
    sources = {name: validate(Source, item, f"{path}: {name}") for name, item in data.items()}
    for name, source in sources.items():
        if source.unit is not None:
            factor(name, source.unit, str(path))
    return sources


def mapped(table: RecordTable, sources: Mapping[str, Source], names: Sequence[str] = NAMES) -> RecordTable:
    """The table with the project's columns and units; without a mapping the same, with the row of units checked."""
    columns = {name: values for name, values in table.columns.items() if name in names or not sources}
    units = {name: unit for name, unit in table.units.items() if name in columns and unit}
    for name, source in sources.items():
        if source.name not in table.columns:
            raise InputError(
                f"{table.path}: column {shown(source.name)} for {name} is missing; "
                f"{meant(source.name, table.columns)}allowed: {', '.join(map(shown, list(table.columns)[:20]))}"
            )
        unit = source.unit or _unit_of(name)
        columns[name] = source.sign * factor(name, unit, table.path) * table.columns[source.name]
        units.pop(name, None)
        written = table.units.get(source.name, "")
        if written and not _same(name, written, unit, table.path):
            raise InputError(
                f"{table.path}: {shown(source.name)} is in {shown(written)}; allowed by the mapping: {unit}"
            )
    for name, written in units.items():
        if name in names and not _same(name, written, _unit_of(name), table.path):
            allowed = f"{_unit_of(name)}, or a mapping file that says otherwise (--columns)"
            raise InputError(f"{table.path}: {name} is in {shown(written)}; allowed: {allowed}")
    return replace(table, columns={name: np.asarray(values) for name, values in columns.items()})


def _same(name: str, written: str, unit: str, path: str) -> bool:
    """Whether two ways to write a unit of a column mean the same."""
    try:
        return factor(name, written, path) == factor(name, unit, path)
    except InputError:
        return False


def _unit_of(name: str) -> str:
    """The unit that a column of the project has in its name."""
    return next(unit for ending, unit in _ENDINGS.items() if name.endswith(ending))


def factor(name: str, unit: str, path: str) -> float:
    """The factor from a unit to that of a column of the project."""
    allowed = UNITS[_unit_of(name)]
    symbols = {_plain(symbol): scale for symbol, scale in allowed.items()}
    capitals = {symbol.casefold(): scale for symbol, scale in symbols.items() if not symbol.startswith("mN")}
    scale = symbols.get(_plain(unit), capitals.get(_plain(unit).casefold()))  # but MN is no mN
    if scale is not None:
        return scale
    raise InputError(f"{path}: {name} has unit {shown(unit)}; allowed: {', '.join(allowed)}")


def _plain(unit: str) -> str:
    """A unit without brackets, blanks and dots between its parts."""
    return re.sub(r"[\s·*_.\[\]()]", "", unit.replace("°", "deg").replace("µ", "u").replace("μ", "u"))
