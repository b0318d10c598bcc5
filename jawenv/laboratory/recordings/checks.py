"""Whether the columns and times of a recording's file can be used."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError, shown
from jawenv.laboratory.recordings.columns import ENCODERS, READINGS, SAMPLES, TIME, TRUE_WRENCH, Column, true_motion
from jawenv.laboratory.recordings.table import RecordTable

Array = NDArray[np.float64]

JITTER = 0.05  # a step of time may differ from the usual one by this share; the times are then taken as even


def check_columns(table: RecordTable, size: int) -> None:
    """Every column is known and finite, and the load cell is there, in one of its two forms.

    Args:
        table: as read.
        size: number of the states (q, u) of the model.

    Raises:
        InputError: it is not so.
    """
    allowed_names = [
        TIME,
        *(column.name for column in (*ENCODERS, *READINGS, *SAMPLES, *true_motion(size), *TRUE_WRENCH)),
    ]
    for name in table.columns:
        if name not in allowed_names:
            allowed = ", ".join([TIME, *(column.name for column in (*ENCODERS, *READINGS))])
            raise InputError(f"{table.path}: column {shown(name)} is unknown; allowed: {allowed} (docs/recordings.md)")
    form = SAMPLES if any(column.name in table.columns for column in SAMPLES) else READINGS
    groups: list[tuple[Column, ...]] = [form]
    groups += [group for group in (tuple(true_motion(size)), TRUE_WRENCH) if has_any(table, group)]
    for group in groups:
        for column in group:
            if column.name not in table.columns:
                raise InputError(
                    f"{table.path}: column {column.name!r} is missing; allowed: all of its group, {len(group)}"
                )
    if form is SAMPLES and has_any(table, READINGS):
        duplicate = next(column.name for column in READINGS if column.name in table.columns)
        raise InputError(
            f"{table.path}: column {duplicate!r} beside three readings per tick; allowed: one of the two forms"
        )
    for column in (*ENCODERS, *form, *true_motion(size), *TRUE_WRENCH):
        bad = np.flatnonzero(np.isinf(table.columns.get(column.name, np.zeros(0))))
        if len(bad):
            raise table.fail(column.name, int(bad[0]), "infinite", "a finite number")


def has_any(table: RecordTable, columns: Sequence[Column]) -> bool:
    """Whether the table has one of these columns."""
    return any(column.name in table.columns for column in columns)


def even_time(table: RecordTable) -> Array:
    """The times from 0, evenly spaced: jitter of a few per cent of a step is taken out.

    Raises:
        InputError: fewer than two times, one that is missing, or uneven ones.
    """
    if TIME not in table.columns:
        names = ", ".join(map(shown, list(table.columns)[:3]))
        raise InputError(
            f"{table.path}: column {TIME!r} is missing; the file begins with {names}; allowed: docs/recordings.md"
        )
    time = table.columns[TIME]
    if len(time) < 2:
        raise InputError(f"{table.path}: holds {len(time)} rows; allowed: two or more")
    bad = np.flatnonzero(~np.isfinite(time))
    if len(bad):
        raise table.fail(TIME, int(bad[0]), "missing", "a number of seconds in every row")
    steps = np.diff(time)
    usual = float(np.median(steps))
    bad = np.flatnonzero(~((steps > 0.0) & (np.abs(steps - usual) <= JITTER * usual)))
    if len(bad):
        value = f"{time[bad[0] + 1]:g}, {steps[bad[0]]:g} s after the row before"
        raise table.fail(
            TIME,
            int(bad[0]) + 1,
            value,
            f"even steps, {usual:g} s in most rows, give or take {JITTER:.0%}, or --resample HZ",
        )
    even: Array = np.linspace(0.0, time[-1] - time[0], len(time))
    return even
