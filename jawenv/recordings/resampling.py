"""Readings on the lines between their neighbours: at even times, and of a sensor slower than a file's rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.recordings.columns import READINGS, SAMPLES, TIME
from jawenv.recordings.table import RecordTable

Array = NDArray[np.float64]

LARGEST_GAP = 0.1
"""s between two readings over which is interpolated."""
FASTEST = 1e4


def on_lines(time: Array, values: Array, at: Array) -> Array:
    """Values at the times ``at`` on lines between readings that are at most ``LARGEST_GAP`` apart; NaN elsewhere.

    Args:
        time: (n,) growing, s.
        values: (n,) NaN where nothing was read.
        at: (m,) s.
    """
    read = ~np.isnan(values)
    if not read.any():
        return np.full(len(at), np.nan)
    times, last = time[read], int(read.sum()) - 1
    before = np.maximum(np.searchsorted(times, at, side="right") - 1, 0)
    after = np.minimum(np.searchsorted(times, at, side="left"), last)
    gap = times[after] - times[before]
    near = (times[before] <= at) & (at <= times[after]) & (gap <= LARGEST_GAP * (1.0 + 1e-9))
    return np.where(near, np.interp(at, times, values[read]), np.nan)


def resampled(table: RecordTable, hz: float) -> RecordTable:
    """The table at ``hz`` rows a second: numbers on the line between the readings before and after.

    Of three load-cell readings per tick the first is kept, which is that at the row's time.

    Args:
        table: with growing times.
        hz: rows per second.
    """
    if not 1.0 / LARGEST_GAP <= hz <= FASTEST:
        raise InputError(f"resample is {hz:g} Hz; allowed: {1.0 / LARGEST_GAP:g} to {FASTEST:g}")
    time = table.columns.get(TIME, np.zeros(0))
    if len(time) < 2 or not np.isfinite(time).all():
        return table  # which is refused where its times are checked
    steps = np.diff(time)
    bad = np.flatnonzero(~((steps > 0.0) & (steps <= LARGEST_GAP)))
    if len(bad):
        value = f"{time[bad[0] + 1]:.12g}, {steps[bad[0]]:g} s after the row before"
        raise table.fail(TIME, int(bad[0]) + 1, value, f"growing times, {LARGEST_GAP:g} s apart at most")
    even = np.arange(int((time[-1] - time[0]) * hz * (1.0 + 1e-12)) + 1) / hz
    single = {sample.name: reading.name for sample, reading in zip(SAMPLES, READINGS, strict=False)}
    dropped = {sample.name for sample in SAMPLES} - set(single)
    columns = {
        single.get(name, name): on_lines(time - time[0], values, even)
        for name, values in table.columns.items()
        if name not in dropped
    }
    before = np.clip(np.searchsorted(time - time[0], even, side="right") - 1, 0, len(time) - 2)
    return replace(table, columns=columns | {TIME: even}, lines=table.lines[before])
