"""Recordings spoilt as people spoil files."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jawenv.recordings.record import Record

Array = NDArray[np.float64]
Spoil = Callable[[Array, Array], tuple[Array, Array]]


def spoilings(start: Array) -> dict[str, Spoil]:
    """Common faults in ``measured`` (T + 1, 12) and ``samples`` (T, 3, 6); ``start`` (3) is the first position."""
    right = np.array([1.0, -1.0, 1.0])
    pitch = np.array([1, 1, 1, -1, 1, 1, 1, 1, 1, 1, -1, 1.0])
    radians = np.repeat([1.0, np.pi / 180.0, 1.0, np.pi / 180.0], 3)
    metres = np.repeat([1e-3, 1.0, 1e-3, 1.0], 3)
    origin = np.concatenate([start, np.zeros(9)])
    force, moment = np.repeat([1.0, 0.0], 3), np.repeat([0.0, 1.0], 3)
    return {
        "forces of the jaw on the device": lambda m, s: (m, -s),
        "degrees written in radians": lambda m, s: (m * radians, s),
        "metres in mm columns": lambda m, s: (m * metres, s),
        "forces in grams": lambda m, s: (m, s * (moment + force * 1e3 / 9.80665)),
        "kilogram-force": lambda m, s: (m, s * (moment + force / 9.80665)),
        "moments in N mm": lambda m, s: (m, s * (force + moment * 1e3)),
        "the tracker's own origin": lambda m, s: (m - origin, s),
        "y to the right": lambda m, s: (
            m * np.concatenate([right, np.ones(3), right, np.ones(3)]),
            s * np.concatenate([right, np.ones(3)]),
        ),
        "pitch opens negative": lambda m, s: (m * pitch, s),
        "a cell's gain of 1.2": lambda m, s: (m, 1.2 * s),
    }


RATES = {"frame numbers as s": 100.0, "ms as s": 1e3, "us as s": 1e6}


def spoilt(record: Record, strength: float) -> Iterator[tuple[str, Record]]:
    """The record, spoilt in each way."""
    m, s = record.measured, record.samples
    for name, change in spoilings(record.measured[0, :3]).items():
        measured, samples = change(m, s)
        yield (
            name,
            replace(record, measured=m + strength * (measured - m), samples=s + strength * (samples - s)),
        )
    if strength == 1.0:
        for name, factor in RATES.items():
            yield name, replace(record, time=record.time * factor)
