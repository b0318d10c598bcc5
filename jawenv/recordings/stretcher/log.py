"""A log of a clinic's stretcher, time, opening and force, read from a file."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.mechanics.dynamics import N_STATES
from jawenv.recordings.columns import FORCE, OPENING, TIME
from jawenv.recordings.mapping import mapped, read_columns
from jawenv.recordings.stretcher.statics import N_PARAMETERS
from jawenv.recordings.table import RecordTable
from jawenv.recordings.words import check_numbers, check_texts

Array = NDArray[np.float64]

COLUMNS = (TIME, OPENING, FORCE)
LIMITS = {OPENING: (-10.0, 80.0), FORCE: (-20.0, 100.0)}
LEAST_ROWS, LEAST_OPENING_MM, LEAST_FORCE_N = 60, 5.0, 2.0
MOST_WINDOWS, ROWS_OF_A_WINDOW = 30, 6
SIGN = ", the force that opens the jaw (else sign = -1 in --columns FILE)"
LEAST_NOISE = 0.02
"""mm and N: digits that a log may leave out."""


@dataclass(frozen=True, eq=False)
class StretchLog:
    """A slow stretch of one jaw: force straight down on the lower incisors against their opening."""

    path: str
    time: Array  # (T,) s
    opening: Array  # (T,) mm from closed teeth, as far as their place is known
    force: Array  # (T,) N
    head_tilt_deg: float = 0.0  # positive looking down


@dataclass(frozen=True, eq=False)
class Windows:
    """Stretches of a log, each as one reading of both columns: the values of parabolas at their middles."""

    opening: Array  # (K,) mm
    force: Array  # (K,) N
    speed: Array  # (K,) mm/s of opening
    opening_sd: Array  # (K,) mm, of noise that differs from row to row
    force_sd: Array  # (K,) N
    loading: NDArray[np.bool_]  # (K,) up to the widest opening

    def __getitem__(self, rows: NDArray[np.bool_]) -> Windows:
        return Windows(*(getattr(self, field.name)[rows] for field in fields(self)))


def log_of_table(table: RecordTable, columns: Path | None = None) -> StretchLog:
    """The log that a file holds, checked."""
    check_texts(table)
    check_numbers(table, {"states": N_STATES, "parameters": N_PARAMETERS})
    table = mapped(table, {} if columns is None else read_columns(columns, COLUMNS), COLUMNS)
    for name in COLUMNS:
        if name not in table.columns:
            raise InputError(f"{table.path}: column {name} is missing; allowed: {', '.join(COLUMNS)}")
    for name in table.columns:
        if name not in COLUMNS:
            raise InputError(f"{table.path}: column {name} is unknown; allowed: {', '.join(COLUMNS)}")
    read = np.all([~np.isnan(table.columns[name]) for name in COLUMNS], axis=0)
    table = replace(table, columns={name: table.columns[name][read] for name in COLUMNS}, lines=table.lines[read])
    for name in COLUMNS:
        low, high = LIMITS.get(name, (-np.inf, np.inf))
        values = table.columns[name]
        bad = np.flatnonzero(~(np.isfinite(values) & (values >= low) & (values <= high)))
        if len(bad):
            allowed = f"{low:g} to {high:g}{SIGN * (name == FORCE)}" if name in LIMITS else "a finite number"
            raise table.fail(name, int(bad[0]), f"{values[bad[0]]:g}", allowed)
    time, opening, force = (table.columns[name] for name in COLUMNS)
    time = _spread(time)
    if len(time) < LEAST_ROWS:
        raise InputError(f"{table.path}: has {len(time)} rows; allowed: {LEAST_ROWS} or more")
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        raise table.fail(TIME, int(back[0]) + 1, f"{time[back[0] + 1]:g}", "growing times")
    for name, values, least in ((OPENING, opening, LEAST_OPENING_MM), (FORCE, force, LEAST_FORCE_N)):
        if np.ptp(values) < least:
            raise InputError(f"{table.path}: {name} changes by {np.ptp(values):.2g}; allowed: {least:g} or more")
    wide = opening >= np.quantile(opening, 0.75)
    if force[wide].mean() < min(force[~wide].mean(), 0.0):
        raise InputError(
            f"{table.path}: {FORCE} is {force[wide].mean():.3g} where the jaw is open; allowed: 0 on{SIGN}"
        )
    return StretchLog(table.path, time, opening, force, float(table.header.get("head_tilt_deg", 0.0)))


def _spread(time: Array) -> Array:
    """Times of which several rows have the same, as in whole seconds, spread evenly up to the next."""
    stamps, first = np.unique(time, return_index=True)
    if len(stamps) < 3 or (np.diff(time) < 0.0).any():
        return time
    rows, last = np.append(first, len(time)), 2.0 * stamps[-1] - stamps[-2]
    spread: Array = np.interp(np.arange(len(time)), rows, np.append(stamps, last))
    return spread


def windows(log: StretchLog) -> Windows:
    """The log in up to thirty windows of as many rows; noise is what the rows scatter about the parabolas."""
    number = min(MOST_WINDOWS, len(log.time) // ROWS_OF_A_WINDOW)
    found, scatter, freedom = [], np.zeros(2), 0
    for rows in np.array_split(np.arange(len(log.time)), number):
        t = log.time[rows] - 0.5 * (log.time[rows[0]] + log.time[rows[-1]])
        columns = np.stack([log.opening[rows], log.force[rows]], -1)
        share = np.linalg.pinv(shape := np.vander(t, 3, increasing=True))
        fitted = share @ columns
        scatter += ((columns - shape @ fitted) ** 2).sum(axis=0)
        freedom += len(rows) - 3
        found.append((*fitted[0], fitted[1, 0], np.linalg.norm(share[0])))
    opening, force, speed, factor = np.array(found).T
    noise = np.hypot(np.sqrt(scatter / freedom), LEAST_NOISE)
    loading = np.arange(number) <= opening.argmax()
    return Windows(opening, force, speed, noise[0] * factor, noise[1] * factor, loading)
