"""Checks of a recording: its quantities, rate, sign, frame, zero, clocks and teeth, and what mends each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from jawenv.recordings.columns import AXES
from jawenv.recordings.estimate import Array
from jawenv.recordings.identification import LARGEST_MISFIT, MOST_REFUSED, identified
from jawenv.recordings.plausibility import SHORTEST_S, findings
from jawenv.recordings.record import Record
from jawenv.recordings.zero import CLOSED_MM, LARGEST_CHANGE_N, UNSEEN_DRIFT, below_closed, change_of_zero

_FIRST_S, _SHORT_S = 60.0, 5.0
"""Length of a recording that is examined, and of its part for each frame that is tried."""
_WINDOW_S, _SLOWEST, _FASTEST = 0.2, 0.9, 1.1
"""Way over the way by the velocities, in windows of so many seconds."""
_START_S, _LARGEST_ZERO_N = 0.02, 0.7
_OF_CHECKS = ("force x velocity", "zero of ")  # findings that a check here looks at
_BETTER = 0.5
"""Misfit in another frame over that as it is, at most."""


@dataclass(frozen=True)
class _Check:
    """One thing that was looked at."""

    what: str
    value: str  # with unit
    fine: bool
    mend: str = ""  # command or line of a mapping file


_CLOCKS = _Check(
    "clocks", "forces that are late cannot be seen: trigger both sensors, or use jawenv import --forces", True
)


def examined(record: Record) -> list[_Check]:
    """The checks of a recording's first minute, in the order in which a bench is put right.

    What a check finds wrong is put right for those after it, as far as numbers tell how.
    """
    if record.time[-1] < SHORTEST_S - 0.5 * record.dt:
        value = f"{record.time[-1]:g} s, allowed: {SHORTEST_S:g} s or more"
        return [_Check("length", value, False, "record longer: less is too short to judge")]
    changed = change_of_zero(record)
    if record.time[-1] > _FIRST_S:
        record = record.until(_FIRST_S)
    rate = _rate(record)
    if not rate.fine:
        return [rate]
    bad = [_Check(one.columns, one.value, False, one.allowed) for one in findings(record) if not one.plausible]
    bad = [check for check in bad if not check.what.startswith(_OF_CHECKS)]
    sign, record = _sign(record)
    frame, record = _frame(record)
    return [rate, *bad, sign, frame, _zero(record, changed), _CLOCKS, _teeth(record)]


def _rate(record: Record) -> _Check:
    found = findings(record)[0]
    mend = 'time_s = {name = "...", unit = "ms"} in --columns FILE, or --resample HZ'
    if not found.plausible:
        return _Check("rate", f"{found.value}; allowed: {found.allowed}", False, mend)
    ratio = _way_by_velocities(record)
    fine = not (ratio < _SLOWEST or ratio > _FASTEST)
    value = found.value if np.isnan(ratio) else f"{found.value}, way over that by the velocities {ratio:.2f}"
    hz = 1.0 / (ratio * record.dt)
    return _Check("rate", value, fine, f"times of {hz:.3g} Hz, or velocities in other units, in --columns FILE")


def _way_by_velocities(record: Record) -> float:
    """Changes of place over what the velocities make of them, by least squares; NaN where one was not read."""
    rows = max(1, round(_WINDOW_S / record.dt))
    place, velocity = record.measured[:, :3], record.measured[:, 6:9]
    if len(place) < 5 * rows:
        return np.nan
    way = np.cumsum(0.5 * record.dt * (velocity[1:] + velocity[:-1]), axis=0)
    change, by_velocity = place[1 + rows :] - place[1:-rows], way[rows:] - way[:-rows]
    read = np.isfinite(change) & np.isfinite(by_velocity)
    total = float(np.sum(by_velocity[read] ** 2))
    return float(np.sum(change[read] * by_velocity[read])) / total if total > 0.0 else np.nan


def _sign(record: Record) -> tuple[_Check, Record]:
    work = next((one for one in findings(record) if one.columns == "force x velocity"), None)
    if work is None:
        return _Check("sign", "the jaw hardly opens: nothing is shown", True), record
    lines = ", ".join(_lines(-np.eye(3)))
    turned = record if work.plausible else replace(record, samples=-record.samples)
    return _Check("sign", work.value, work.plausible, f"{lines} in --columns FILE"), turned


def _frame(record: Record) -> tuple[_Check, Record]:
    """Whether some muscles explain the readings, and if not, whether they do in another frame of the load cell."""
    as_it_is = _misfit(record)
    value = f"misfit {as_it_is:.3g}, allowed: {LARGEST_MISFIT:g}"
    if as_it_is <= LARGEST_MISFIT:
        return _Check("frame", value, True), record
    short = record.until(_SHORT_S) if record.time[-1] > _SHORT_S else record
    before, found = _misfit(short), []
    for words, mend, samples in _frames(short):
        moved = replace(short, samples=samples)
        if all(one.plausible for one in findings(moved)):
            found.append((_misfit(moved), words, mend))
    best, words, mend = min(found, default=(np.inf, "", ""))
    if best > min(LARGEST_MISFIT, _BETTER * before):
        return _Check("frame", value, True), record  # it is something else
    samples = next(samples for one, _, samples in _frames(record) if one == words)
    return _Check("frame", f"{value}; {best:.2g} {words}", False, mend), replace(record, samples=samples)


def _misfit(record: Record) -> float:
    """The alarm, infinite where the gate refuses too much."""
    found = identified(record)
    return found.misfit if found.refused <= MOST_REFUSED * max(found.rows, 1) else np.inf


def _frames(record: Record) -> Iterator[tuple[str, str, Array]]:
    """Ways in which a load cell may sit, in words, as lines of a mapping, and with the forces in the body's axes."""
    vectors = record.samples.reshape(*record.samples.shape[:2], 2, 3)
    for axis in range(3):
        one, other = ((axis + 1) % 3, (axis + 2) % 3)
        turn = np.zeros((3, 3))
        turn[axis, axis], turn[one, other], turn[other, one] = 1.0, -1.0, 1.0
        for quarters in (1, 2, 3):
            matrix = np.linalg.matrix_power(turn, quarters)
            words = f"with the cell turned by {90 * quarters} degrees about {AXES[axis]}"
            mend = ", ".join(_lines(matrix)) + " in --columns FILE"
            yield words, mend, (vectors @ matrix.T).reshape(record.samples.shape)
    pitch = np.nan_to_num(record.measured[:-1, 3])[:, None, None]
    x, z = vectors[..., 0], vectors[..., 2]
    body = np.stack([np.cos(pitch) * x - np.sin(pitch) * z, vectors[..., 1], np.sin(pitch) * x + np.cos(pitch) * z], -1)
    yield (
        "with forces in head axes",
        "turn forces and moments into the mandible's axes",
        body.reshape(record.samples.shape),
    )


def _lines(matrix: Array) -> list[str]:
    """Lines of a mapping file that make the body's force of the file's; moments alike."""
    lines = []
    for axis, row in zip(AXES, np.round(matrix).astype(int), strict=True):
        k = int(np.argmax(np.abs(row)))
        if row[k] < 0 or AXES[k] != axis:
            sign = ", sign = -1" if row[k] < 0 else ""
            lines.append(f'force_{axis}_N = {{name = "force_{AXES[k]}_N"{sign}}}')
    return [*lines, "moments alike"]


def _zero(record: Record, changed: float | None) -> _Check:
    """The force at the start, where the jaw rests and the device is slack, and whether the end shows the same."""
    first = record.samples[: max(1, round(_START_S / record.dt)), :, :3]
    if not np.isfinite(first).any(axis=(0, 1)).all() or not below_closed(record)[0] < CLOSED_MM:
        return _Check("zero", "the recording does not begin with the jaw closed: nothing is shown", True)
    force = np.nanmean(first, axis=(0, 1))
    value = f"{', '.join(f'{x:.2f}' for x in force)} N at the start, allowed: {_LARGEST_ZERO_N:g} N each"
    mend = "tare the cell with the device slack, or begin the recording before it pulls"
    fine = bool(np.abs(force).max() <= _LARGEST_ZERO_N)
    if changed is None:
        return _Check("zero", f"{value}; a drift cannot be seen: {UNSEEN_DRIFT}", fine, mend)
    if fine and changed > LARGEST_CHANGE_N:
        fine, mend = False, "let the cell warm up, tare it, record again"
    return _Check(
        "zero", f"{value}; {changed:.2g} N more or less at the end, allowed: {LARGEST_CHANGE_N:g} N", fine, mend
    )


def _teeth(record: Record) -> _Check:
    below = below_closed(record)
    if np.isnan(below).all():
        return _Check("teeth", "no height of the mouthpiece was read: nothing is shown", True)
    nearest = float(np.nanmin(below))
    value = f"mouthpiece {nearest:.1f} mm below its place with the jaw closed at the least, allowed: {CLOSED_MM:g} mm"
    return _Check("teeth", value, nearest <= CLOSED_MM, "begin with the teeth together")
