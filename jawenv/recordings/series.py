"""Time series of a recording's table: columns of a file as arrays of a record, and the other way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings.checks import has_any
from jawenv.recordings.columns import ENCODERS, READINGS, SAMPLES, TIME, Column
from jawenv.recordings.record import Record
from jawenv.recordings.resampling import on_lines
from jawenv.recordings.table import RecordTable

Array = NDArray[np.float64]

_SLOWER = 1.2  # rows from one reading of the load cell to the next, from which on its readings are on lines


def written(record: Record, column: Column) -> Array:
    """A column of T + 1 numbers; what belongs to a tick stands in the row in which the tick begins."""
    values = getattr(record, column.field)[(slice(None), *column.index)] * column.scale
    short = len(record.time) - len(values)
    return np.concatenate([values, np.full(short, np.nan)])


def _column(table: RecordTable, column: Column) -> Array:
    values = table.columns.get(column.name)
    return np.full(len(table.lines), np.nan) if values is None else values / column.scale


def begun(table: RecordTable) -> RecordTable:
    """The table from the first row on in which an encoder was read: a load cell may start before the tracker."""
    read = np.isfinite([table.columns[each.name] for each in ENCODERS if each.name in table.columns]).any(axis=0)
    first = int(np.argmax(read)) if np.any(read) else 0
    if not first:
        return table
    columns = {name: values[first:] for name, values in table.columns.items()}
    return replace(table, columns=columns, lines=table.lines[first:])


def encoders(table: RecordTable) -> Array:
    """(T + 1, 12) readings, of which the first row has at least one."""
    measured = np.column_stack([_column(table, column) for column in ENCODERS])
    if not np.isfinite(measured[0]).any():
        allowed = ", ".join(column.name for column in ENCODERS)
        raise InputError(f"{table.path}: no encoder was read; allowed: one or more of {allowed}")
    return measured


def stacked(table: RecordTable, columns: Sequence[Column]) -> Array | None:
    """(T + 1, n) of these columns; None without them in the file."""
    if columns[0].name not in table.columns:
        return None
    return np.column_stack([_column(table, column) for column in columns])


def wrenches(table: RecordTable, columns: tuple[Column, ...]) -> Array:
    """(T, 3, 6) of three wrenches per tick, NaN where none was read; the last row begins no tick."""
    wrenches: Array = np.empty((len(table.lines) - 1, N_SAMPLES, N_WRENCH))
    for column in columns:
        moment, component = column.index
        wrenches[:, moment, component] = _column(table, column)[:-1]
    return wrenches


def samples(table: RecordTable, slack: bool) -> Array:
    """(T, 3, 6) force at start, middle and end of each tick; between single readings it is interpolated."""
    form = SAMPLES if has_any(table, SAMPLES) else READINGS
    for column in form:
        if not (slack or np.isfinite(_column(table, column)).any()):
            raise table.fail(column.name, 0, "empty", "a reading of the load cell in one row or more")
    if form is SAMPLES:
        return wrenches(table, SAMPLES)
    time = table.columns[TIME]
    readings = np.column_stack([on_lines(time, _column(table, column), time) for column in READINGS])
    return np.stack([readings[:-1], 0.5 * (readings[:-1] + readings[1:]), readings[1:]], axis=1)


def line_variance(table: RecordTable, cell_sd: Array) -> Array:
    """(6,) variance of a tick's wrench by lines between readings of a cell slower than the rows; 0 for no such cell.

    A reading counts in all ticks up to the next one, with its noise and with what the force bends away from the line:
    errors that last for n ticks weigh as white ones of n times the variance.

    Args:
        table: of the file.
        cell_sd: (6,) sd of the mean of the two readings of a tick.
    """
    variance = np.zeros(N_WRENCH)
    if has_any(table, SAMPLES):
        return variance
    for k, column in enumerate(READINGS):
        values = _column(table, column)
        read = np.flatnonzero(~np.isnan(values))
        steps = np.diff(read)
        if len(read) < 3 or (ticks := float(steps[steps <= 2.0 * np.median(steps)].mean())) < _SLOWER:
            continue
        bent = np.diff(values[read], 2) / np.sqrt(120.0)  # root mean square of a parabola about its chord
        variance[k] = ticks * (2.0 * cell_sd[k] ** 2 + np.mean(bent**2))
    return variance
