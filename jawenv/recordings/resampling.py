"""A table with uneven times, interpolated to even ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jawenv.base.errors import InputError
from jawenv.recordings.columns import READINGS, SAMPLES, TIME
from jawenv.recordings.table import RecordTable

LARGEST_GAP = 0.1
"""s between two rows over which a motion is interpolated."""
FASTEST = 1e4


def resampled(table: RecordTable, hz: float) -> RecordTable:
    """The table at ``hz`` rows a second: numbers on the line between the rows before and after.

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
    before = np.clip(np.searchsorted(time - time[0], even, side="right") - 1, 0, len(time) - 2)
    share = (even - (time[before] - time[0])) / steps[before]
    single = {sample.name: reading.name for sample, reading in zip(SAMPLES, READINGS, strict=False)}
    dropped = {sample.name for sample in SAMPLES} - set(single)
    columns = {}
    for name, values in table.columns.items():
        if name not in dropped:
            between = np.where(share > 0.0, share * (values[before + 1] - values[before]), 0.0)
            columns[single.get(name, name)] = values[before] + between
    return replace(table, columns=columns | {TIME: even}, lines=table.lines[before])
