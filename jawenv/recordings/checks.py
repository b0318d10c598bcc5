"""Whether the columns and times of a recording's file can be used."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown
from jawenv.recordings.columns import ENCODERS, READINGS, SAMPLES, TIME, TRUE_MOTION, TRUE_WRENCH, Column
from jawenv.recordings.resampling import LARGEST_GAP
from jawenv.recordings.table import RecordTable

Array = NDArray[np.float64]

JITTER = 0.05
"""Share of a step by which a time may lie off a straight line, beside what its digits leave open."""
MOST_OFF = 0.4
"""The same at most: from a half on, a row may be missing."""
DIGITS = 9
"""After the point: nobody writes more."""


def check_columns(table: RecordTable) -> None:
    """Every column is known and finite, and the load cell is there, in one of its two forms."""
    allowed_names = [
        TIME,
        *(column.name for column in (*ENCODERS, *READINGS, *SAMPLES, *TRUE_MOTION, *TRUE_WRENCH)),
    ]
    for name in table.columns:
        if name not in allowed_names:
            allowed = ", ".join([TIME, *(column.name for column in (*ENCODERS, *READINGS))])
            raise InputError(f"{table.path}: column {shown(name)} is unknown; allowed: {allowed} (docs/recordings.md)")
    form = SAMPLES if any(column.name in table.columns for column in SAMPLES) else READINGS
    groups: list[tuple[Column, ...]] = [form]
    groups += [group for group in (TRUE_MOTION, TRUE_WRENCH) if has_any(table, group)]
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
    for column in (*ENCODERS, *form, *TRUE_MOTION, *TRUE_WRENCH):
        bad = np.flatnonzero(np.isinf(table.columns.get(column.name, np.zeros(0))))
        if len(bad):
            raise table.fail(column.name, int(bad[0]), "infinite", "a finite number")


def has_any(table: RecordTable, columns: Sequence[Column]) -> bool:
    """Whether the table has one of these columns."""
    return any(column.name in table.columns for column in columns)


def even_time(table: RecordTable) -> Array:
    """The times from 0, evenly spaced, without jitter of a few per cent of a step and rounding of the stamps."""
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
    off, resolution = np.abs(_from_line(time)), _resolution(time)
    most = min(JITTER * usual + 0.5 * resolution, MOST_OFF * usual)
    if not (steps > 0.0).all() or off.max() > most:
        jumps = np.flatnonzero(~((steps > 0.0) & (np.abs(steps - usual) <= JITTER * usual + resolution)))
        row = int(jumps[0]) if len(jumps) else int(np.argmax(off[1:]))
        value = f"{time[row + 1]:g}, {steps[row]:g} s after the row before"
        value += "" if len(jumps) else f" and {off[row + 1]:.2g} s off even times"
        whole = bool(((steps > 0.0) & (steps <= LARGEST_GAP)).all())
        way = "or --resample HZ of identify, suggest and import" if whole else "one take: cut the file before this row"
        allowed = f"even steps, {usual:g} s in most rows, give or take {JITTER:.0%}, {way}"
        raise table.fail(TIME, row + 1, value, allowed)
    even: Array = np.linspace(0.0, time[-1] - time[0], len(time))
    return even


def _from_line(time: Array) -> Array:
    """Deviation of each time from the straight line through all, s."""
    rows = np.arange(len(time)) - 0.5 * (len(time) - 1)
    since = time - time.mean()
    off: Array = since - rows * (rows @ since) / (rows @ rows)
    return off


def _resolution(time: Array) -> float:
    """The step of the digits that the times are written with, s; of the later half, as those have the fewest."""
    later = time[len(time) // 2 :]
    rounding = 1e-9 + 4.0 * float(np.spacing(np.abs(later).max()))
    whole = (digits for digits in range(DIGITS) if (np.abs(later - np.round(later, digits)) <= rounding).all())
    return 10.0 ** -next(whole, DIGITS)
