"""Whether a recording can be one of a jaw on a device, quantity by quantity, before any filter sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.device.device import Device
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings.record import Record
from jawenv.recordings.resampling import LARGEST_GAP
from jawenv.recordings.zero import LARGEST_CHANGE_N, change_of_zero

Array = NDArray[np.float64]

SLOWEST, FASTEST = 20.0, 1000.0
"""Hz."""
REACH = 30.0
"""mm from the mouthpiece's place with the jaw closed to that of the first row."""
LOWEST_PITCH, HIGHEST_PITCH = -5.0, 45.0
"""Degrees."""
LEVER = 0.1
"""m: the largest moment is the largest force times this."""
OPENING = 2e-3
"""m/s of the mouthpiece downwards."""
LEAST_WORK_SHARE = -0.2
"""Work of the device on an opening jaw over its magnitude: a passive jaw gives back what it has stored, and no more."""
SMOOTHING_S, FEWEST_ROWS = 0.1, 20
SHORTEST_S, LEAST_MM = 1.0, 1.5
"""Least length of a recording that can be judged, and least travel of its mouthpiece."""
MOVES_MM, TURNS = 5.0, 0.2
"""A mouthpiece that moves so far up and down turns by at least this share of a hinge's angle; radians are a 57th."""
MOST = 99.0
"""Per cent of the readings that are looked at: of a few that are far off the filter makes nothing."""
LEAST_READ, MOST_REPEATED = 0.8, 0.3
"""Shares of the ticks: with a force, and with the same numbers as the tick before."""
STEPS = 2.5
"""Smallest jump of held numbers, in steps; a step is the smallest change of a column."""


@dataclass(frozen=True)
class Finding:
    """One quantity of a recording."""

    columns: str  # that show it
    value: str  # what they hold, with unit
    allowed: str  # what a jaw on a device can show, and what to look at
    plausible: bool  # whether it does
    spoils: bool = True  # whether another value is no jaw's; else it is one that tells nothing


def findings(record: Record) -> list[Finding]:
    """Checks of a recording's rate, position, angles, forces and their work, as far as they were read."""
    hz = 1.0 / record.dt
    rate = Finding(
        "time_s", f"{hz:.4g} Hz", "20 to 1000 Hz: seconds, no frame numbers", SLOWEST <= hz * 1.001 <= FASTEST
    )
    moved = [*_motion(record), *_place(record), *_pitch(record)]
    return [rate, _length(record), *_read(record), *moved, *_wrench(record), *_work(record), *_zero(record)]


def _read(record: Record) -> list[Finding]:
    """Whether forces were read in most ticks, and whether each reading stands in the file once."""
    found, cell = [], record.samples
    if record.force_sensor == "cell":
        share, gap = float(np.isfinite(cell).all(axis=(1, 2)).mean()), LARGEST_GAP
        allowed = f"{100 * LEAST_READ:g} % or more: single readings at most {gap:g} s apart are joined, others are not"
        value = f"read in {100.0 * share:.3g} % of the ticks"
        found.append(Finding("force_*_N", value, allowed, share >= LEAST_READ, spoils=False))
    noisy = record.cell_sd > 0.0  # one without noise may repeat itself, as when no motor pushes
    forces = np.concatenate([cell[:, 0], cell[-1:, 2]])[:, noisy]
    for columns, rows in (("mouthpiece_*_mm, *_deg", record.measured[:, :6]), ("force_*_N", forces)):
        share = _repeated(rows)
        if share > MOST_REPEATED:
            allowed = f"{100 * MOST_REPEATED:g} %: write a reading once, in its row, and leave the rows between empty"
            found.append(Finding(columns, f"repeated readings in {100.0 * share:.3g} % of the rows", allowed, False))
    return found


def _repeated(rows: Array) -> float:
    """Share of the rows (T, n) in which all numbers stay equal before one jumps: held readings of a slower sensor.

    A sensor that rounds to steps stays equal too, and then moves on by a step or two.
    """
    change = np.abs(np.diff(rows, axis=0))
    moved = np.where(change > 0.0, change, np.nan)
    if np.isnan(moved).all():
        return 0.0
    columns = ~np.isnan(moved).all(axis=0)
    jump = np.nan_to_num(moved[:, columns] / np.nanmin(moved[:, columns], axis=0)).max(axis=1)
    moves = np.flatnonzero(jump)
    equal = np.flatnonzero((jump == 0.0) & np.isfinite(change).any(axis=1))
    after_them = np.searchsorted(moves, equal)
    ended = after_them[after_them < len(moves)]
    return float(np.sum(jump[moves[ended]] > STEPS) / len(change))


def _length(record: Record) -> Finding:
    seconds, rows = float(record.time[-1] - record.time[0]), len(record.time)
    allowed = f"{SHORTEST_S:g} s or more: less is too short to judge"
    long = seconds >= SHORTEST_S - 0.5 * record.dt
    return Finding("length", f"{seconds:.3g} s, {rows:,} rows", allowed, long, spoils=False)


def _motion(record: Record) -> list[Finding]:
    place = 1e3 * record.measured[:, :3]
    if not np.isfinite(place).all(axis=1).any():
        return []
    moved = float(np.ptp(np.nanpercentile(place, (100.0 - MOST, MOST), axis=0), axis=0).max())
    allowed = f"{LEAST_MM:g} mm or more: a jaw that is not moved tells nothing"
    return [Finding("motion", f"{moved:.3g} mm of the mouthpiece", allowed, moved >= LEAST_MM, spoils=False)]


def _place(record: Record) -> list[Finding]:
    rows, closed = np.zeros((N_MEASUREMENTS, len(record.start_mean))), np.zeros(N_MEASUREMENTS)
    measure(record.jaw, np.zeros(len(record.start_mean)), rows, closed)
    first = record.measured[0, :3]
    if np.isnan(first).all():
        return []
    distance = 1e3 * float(np.sqrt(np.nansum((first - closed[:3]) ** 2)))
    where = ", ".join(f"{1e3 * x:.0f}" for x in closed[:3])
    allowed = f"within {REACH:g} mm of {where} (closed jaw): mm, axes, origin between the condyles"
    return [Finding("mouthpiece_*_mm", f"begins {distance:.3g} mm from the closed jaw", allowed, distance <= REACH)]


def _pitch(record: Record) -> list[Finding]:
    pitch = np.degrees(record.measured[:, 3])
    if np.isnan(pitch).all():
        return []
    low, high = np.nanpercentile(pitch, (100.0 - MOST, MOST))
    place = 1e3 * record.measured[:, 2]
    moved = 0.0 if np.isnan(place).all() else float(np.ptp(np.nanpercentile(place, (100.0 - MOST, MOST))))
    hinge = np.degrees(moved / (1e3 * float(record.jaw["mouthpiece"][0])))
    if moved >= MOVES_MM and high - low < TURNS * hinge:
        value = f"turns {high - low:.2g} deg while the mouthpiece moves {moved:.2g} mm"
        return [Finding("pitch_deg", value, f"about {hinge:.0f} deg: degrees, no radians", False)]
    allowed = f"{LOWEST_PITCH:g} to {HIGHEST_PITCH:g} deg: degrees, positive while open"
    plausible = bool(low >= LOWEST_PITCH and high <= HIGHEST_PITCH)
    return [Finding("pitch_deg", f"{low:.3g} to {high:.3g} deg", allowed, plausible)]


def _wrench(record: Record) -> list[Finding]:
    cap = (record.device or Device()).force_cap_N
    sizes = np.abs(record.samples).reshape(-1, N_WRENCH)
    largest = [np.nanpercentile(column, MOST) if np.isfinite(column).any() else 0.0 for column in sizes.T]
    force, moment = max(largest[:3]), max(largest[3:])
    return [
        Finding("force_*_N", f"up to {force:.3g} N", f"up to {cap:g} N, the device's cap: newtons", bool(force <= cap)),
        Finding(
            "moment_*_N_m",
            f"up to {moment:.3g} N m",
            f"up to {LEVER * cap:g} N m: N m, about the mouthpiece",
            bool(moment <= LEVER * cap),
        ),
    ]


def _work(record: Record) -> list[Finding]:
    """The sign of the work that the device does on the mouthpiece while the jaw opens."""
    velocity = record.measured[:-1, 6:9]
    if np.isnan(velocity).any():
        positions, width = record.measured[:, :3], max(1, round(SMOOTHING_S / record.dt))
        if np.isnan(positions).any() or len(positions) < 2 * width:
            return []
        kernel = np.full(width, 1.0 / width)
        smooth = np.column_stack([np.convolve(column, kernel, mode="same") for column in positions.T])
        velocity = np.gradient(smooth, record.dt, axis=0)[:-1]
        velocity[:width] = velocity[-width:] = 0.0
    pitch = np.nan_to_num(record.measured[:-1, 3])
    force = record.samples.mean(axis=1)[:, :3]
    x = np.cos(pitch) * force[:, 0] + np.sin(pitch) * force[:, 2]
    z = np.cos(pitch) * force[:, 2] - np.sin(pitch) * force[:, 0]
    power = x * velocity[:, 0] + force[:, 1] * velocity[:, 1] + z * velocity[:, 2]
    power = power[(velocity[:, 2] < -OPENING) & np.isfinite(power)]
    if len(power) < FEWEST_ROWS:
        return []
    share = float(power.sum() / np.abs(power).sum())
    allowed = f"above {100 * LEAST_WORK_SHARE:.0f} %: the force of the device on the jaw, no sign turned"
    return [Finding("force x velocity", f"{100 * share:.0f} % of the work opens", allowed, share > LEAST_WORK_SHARE)]


def _zero(record: Record) -> list[Finding]:
    """Whether the load cell shows the same at both ends, where they are told to compare."""
    changed = change_of_zero(record)
    if changed is None:
        return []
    value = f"differs by {changed:.2g} N between the ends, teeth together"
    allowed = f"{LARGEST_CHANGE_N:g} N: let the cell warm up, tare it, record again"
    return [Finding("zero of force_*_N", value, allowed, changed <= LARGEST_CHANGE_N, spoils=False)]
