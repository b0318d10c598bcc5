"""The load cell's zero at the two ends of a recording, where the teeth are together and the device is slack."""

from __future__ import annotations

import numpy as np

from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.recordings.estimate import Array
from jawenv.recordings.record import Record

CLOSED_MM = 3.0
"""Distance from the closed jaw's place within which the teeth are together."""
UNSEEN_DRIFT = "end as you began, teeth together, the device slack and still"
LARGEST_CHANGE_N = 0.5
"""Change of the zero from which nothing is believed: slow movements with 1 N have NEES/12 of 2.6 to 4."""
_END_S, _STILL_MM = 0.5, 0.1
"""Length of an end, and how far its halves and the two ends may lie apart."""


def below_closed(record: Record) -> Array:
    """(T + 1,) mm of the mouthpiece below its place with the jaw closed, NaN where not read."""
    rows, closed = np.zeros((N_MEASUREMENTS, len(record.start_mean))), np.zeros(N_MEASUREMENTS)
    measure(record.jaw, np.zeros(len(record.start_mean)), rows, closed)
    below: Array = 1e3 * (closed[2] - record.measured[:, 2])
    return below


def change_of_zero(record: Record) -> float | None:
    """N by which the force differs between the ends; None where teeth are apart or the jaw is not at rest in one.

    What the teeth's springs make of the height between the two places is no change.
    """
    half = round(0.5 * _END_S / record.dt)
    if half < 1 or len(record.samples) < 8 * half:
        return None
    parts = [slice(half), slice(half, 2 * half), slice(-2 * half, -half), slice(-half, None)]
    place = np.array([_mean(record.measured[part, :3]) for part in parts])
    force = np.array([_mean(record.samples[part, :, :3].reshape(-1, 3)) for part in parts])
    apart = 1e3 * np.linalg.norm(place - np.roll(place, 1, axis=0), axis=1).max()
    below = max(abs(_mean(below_closed(record)[part])) for part in parts)
    if not (apart <= _STILL_MM and below <= CLOSED_MM and np.isfinite(force).all()):
        return None
    ends = place.reshape(2, 2, 3).mean(axis=1)
    by_teeth = len(record.jaw["teeth"]) * float(record.jaw["tooth_stiffness"]) * abs(ends[1, 2] - ends[0, 2])
    changed = np.abs(np.subtract(*force.reshape(2, 2, 3).mean(axis=1))).max()
    return float(max(changed - by_teeth, 0.0))


def _mean(values: Array) -> Array:
    """Mean over the rows that were read, NaN without any."""
    mean: Array = np.ma.masked_invalid(values).mean(axis=0)
    return np.ma.filled(mean, np.nan)
