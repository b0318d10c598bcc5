"""A delay between the clocks of motion and force, as the readings show it, taken out of a recording.

The forces are read earlier and later, all muscles and other unknowns are integrated out, and the shift under which the
readings are most probable is the delay. What shows it within a millisecond is how the device answers to what the noise
does to the jaw. A servo's answer is in the reading of the same tick, so that without a delay readings fit best with
the forces ``_SERVO_S`` early: 7.1 ms with an sd of 0.5 ms in 15 simulated recordings of three movements. A servo of 300
N/m has 6.6 to 8.4 ms. A real device has a figure of its own, so delays below ``_LEAST_S`` are left alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jawenv.recordings import defaults
from jawenv.recordings.defaults import UNMODELLED_TIME
from jawenv.recordings.identification import identified
from jawenv.recordings.record import Record
from jawenv.recordings.thinning import divided
from jawenv.recordings.untold.bank import evidence
from jawenv.recordings.untold.blocks import blocks_of

_SERVO_S = 0.007
_COARSE_S, _FINE_S, _FURTHEST_S = 0.01, 0.005, 0.06
"""S between the shifts that are tried, first and beside the best, and the furthest."""
_LARGEST_S = 0.035
"""Of a delay that is taken out, 30 ms and its error: one that is larger is no matter of clocks that nearly agree."""
_LEAST_S, _LEAST_NATS = 0.008, 50.0
"""A delay is taken for one that is there from here on, if the readings are so much more probable with it."""
_LONG_S = 20.0
"""Of a recording that is looked at."""


@dataclass(frozen=True)
class _Delay:
    """Delay of the forces; negative where they are early."""

    seconds: float
    nats: float  # by which the readings are more probable with it than without; 0 where nothing is told

    @property
    def shown(self) -> bool:
        """Whether the clocks disagree."""
        return abs(self.seconds) >= _LEAST_S and self.nats >= _LEAST_NATS

    @property
    def too_late(self) -> bool:
        """Whether they disagree by more than is taken out."""
        return self.shown and abs(self.seconds) > _LARGEST_S

    def __str__(self) -> str:
        """Tell it in words."""
        if not self.shown:
            return "no delay is seen between motion and forces"
        late = f"forces are {1e3 * abs(self.seconds):.0f} ms {'late' if self.seconds > 0.0 else 'early'}"
        return f"{late}, more than the 30 ms that are taken out" if self.too_late else late


def in_time(record: Record) -> tuple[Record, _Delay]:
    """The recording with forces at their times, and the delay that was found.

    It is as it was where no delay is shown or one that is too large, and where all is known exactly: so are clocks.
    """
    delay = _Delay(0.0, 0.0) if record.knowledge.exact else delay_of(record)
    if not delay.shown or delay.too_late:
        return record, delay
    rows = int(np.ceil(abs(delay.seconds) / record.dt))
    moved = _shifted(record, delay.seconds)
    return (_cut(moved, 0, rows) if delay.seconds > 0.0 else _cut(moved, rows, 0)), delay


def delay_of(record: Record) -> _Delay:
    """Delay of the forces of a recording; 0 where it is too short, or no load cell is read within ticks."""
    margin = int(np.ceil((_FURTHEST_S + _FINE_S) / record.dt)) + 1
    alone = record.force_sensor != "cell" or _once_a_tick(record)
    if alone or record.time[-1] < 1.0 + 2.0 * margin * record.dt:
        return _Delay(0.0, 0.0)
    if record.time[-1] > _LONG_S:
        record = record.until(_LONG_S)
    mean = identified(record).estimate.mean[-1]
    parts = max(1, round(record.dt / UNMODELLED_TIME))
    unknowns = blocks_of(divided(_cut(record, margin, margin), parts), mean).unknowns()
    tried: dict[float, float] = {}

    def probable(seconds: float) -> float:
        if seconds not in tried:
            moved = divided(_cut(_shifted(record, seconds), margin, margin), parts)
            tried[seconds] = evidence(blocks_of(moved, mean, unknowns))
        return tried[seconds]

    number = round(_FURTHEST_S / _COARSE_S)
    best = max((_COARSE_S * k for k in range(1 - number, number)), key=probable)
    best = max((best - _FINE_S, best, best + _FINE_S), key=probable)
    low, middle, high = (probable(best + _FINE_S * k) for k in (-1, 0, 1))
    bend = 2.0 * middle - low - high
    top = best + (0.5 * _FINE_S * (high - low) / bend if bend > 0.0 else 0.0)
    return _Delay(float(top + _SERVO_S), middle - max(probable(-_COARSE_S), probable(-_FINE_S)))


def _once_a_tick(record: Record) -> bool:
    """Whether forces within a tick lie on lines between those at its ends: then nothing answers within it."""
    within = record.samples[:, 1] - 0.5 * (record.samples[:, 0] + record.samples[:, 2])
    return bool(np.nanmedian(np.abs(within)) < 1e-9)


def _shifted(record: Record, seconds: float) -> Record:
    """The record with the forces that were read ``seconds`` later; at its ends some are held."""
    ticks = len(record.samples)
    place = np.arange(ticks)[:, None] + np.array([0.0, 0.5, 1.0]) + seconds / record.dt
    tick = np.floor(place)
    tick[:, 2] = np.ceil(place[:, 2]) - 1.0  # the end of a tick, not the start of the next
    tick = np.clip(tick, 0, ticks - 1)
    share = np.clip(place - tick, 0.0, 1.0)
    weights = np.maximum(0.0, 1.0 - np.abs(2.0 * share[..., None] - np.arange(3.0)))  # on the lines between samples
    samples = np.einsum("tos,tosk->tok", weights, record.samples[tick.astype(int)])
    return replace(record, samples=samples, wrenches=None)


def _cut(record: Record, first: int, last: int) -> Record:
    """The record without so many rows at its start and at its end."""
    measured = record.measured[first : len(record.measured) - last]
    seen = np.isfinite(measured).any(axis=1)
    more = int(np.argmax(seen))  # a record begins with a reading
    first, measured = first + more, measured[more:]
    start: dict[str, Any] = {"start_mean": record.start_mean, "start_sd": record.start_sd}
    if first:
        motion = defaults.motion_of_reading(record.jaw, measured[0], record.measurement_sd)
        start = {"start_mean": motion, "start_sd": defaults.start_sd(record.jaw)}
    return replace(
        record,
        time=record.time[first : len(record.time) - last] - record.time[first],
        measured=measured,
        samples=record.samples[first : len(record.samples) - last],
        states=None,
        wrenches=None,
        **start,
    )
