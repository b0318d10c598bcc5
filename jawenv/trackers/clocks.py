"""The offset between two clocks, from one motion that both files saw."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from jawenv.base.errors import InputError

Array = NDArray[np.float64]

GRID_S = 0.005
"""s between the offsets that are tried; between them a parabola finds the best."""
LEAST_OVERLAP = 0.5
"""Share of the shorter file that both have to cover."""
LEAST_CORRELATION = 0.5
PROMINENCE = 0.05
"""A smaller rise of the correlation is noise on the way to a peak."""
ALIKE = 1.5
"""Two offsets fit alike where the unexplained variances differ by less than this factor."""


LARGEST_SD_S = 0.002
"""Estimates of a fast maneuver err by half as much again for an offset that is wrong by 5 ms, and not for 2 ms."""


@dataclass(frozen=True)
class _Offset:
    """Reading of the other clock when the first shows 0."""

    seconds: float  # of the other clock
    sd_s: float  # standard error, of a pure delay and the residual's own memory
    correlation: float  # of the two signals at this offset


def clock_offset(time: Array, signal: Array, other_time: Array, other: Array) -> _Offset:
    """The offset at which two signals correlate best.

    Args:
        time: (T,) s, growing.
        signal: (T,), NaN where not read.
        other_time: (S,) s of the other clock, growing.
        other: (S,), NaN likewise.
    """
    first, second = _on_grid(time, signal), _on_grid(other_time, other)
    least = max(3, int(LEAST_OVERLAP * min(len(first), len(second))))
    lags = range(least - len(first), len(second) - least + 1)
    found = np.array([_correlation(*_overlap(first, second, lag)) for lag in lags])
    peaks = find_peaks(np.concatenate([[-2.0], found, [-2.0]]), prominence=PROMINENCE)[0] - 1
    best = int(np.argmax(found))
    if not found[best] >= LEAST_CORRELATION:
        raise InputError(
            f"the two files correlate by {found[best]:.2f} at best; "
            f"allowed: {LEAST_CORRELATION:g} or more (a sign turned?), or --offset SECONDS"
        )
    for peak in peaks[peaks != best]:
        if 1.0 - found[peak] ** 2 < ALIKE * (1.0 - found[best] ** 2):
            seconds = [f"{_seconds(lags[i], time, other_time):.3g}" for i in (best, peak)]
            raise InputError(f"offsets of {seconds[0]} and {seconds[1]} s fit alike; allowed: --offset SECONDS")
    offset = _Offset(_seconds(lags[best] + _peak(found, best), time, other_time), *_error(first, second, lags[best]))
    if offset.sd_s > LARGEST_SD_S:
        allowed = f"{1e3 * LARGEST_SD_S:g} ms, or --offset SECONDS"
        raise InputError(f"the offset of the clocks is known within {1e3 * offset.sd_s:.2g} ms; allowed: {allowed}")
    return offset


def _on_grid(time: Array, signal: Array) -> Array:
    seen = np.isfinite(signal)
    if seen.sum() < 2:
        raise InputError("fewer than two readings to compare; allowed: more, or --offset SECONDS")
    grid: Array = np.interp(np.arange(time[0], time[-1], GRID_S), time[seen], signal[seen])
    return grid


def _overlap(first: Array, second: Array, lag: int) -> tuple[Array, Array]:
    """The parts of two signals on one another where the second is read ``lag`` steps later."""
    length = min(len(first) - max(-lag, 0), len(second) - max(lag, 0))
    return first[max(-lag, 0) :][:length], second[max(lag, 0) :][:length]


def _correlation(first: Array, second: Array) -> float:
    a, b = first - first.mean(), second - second.mean()
    scale = np.sqrt((a @ a) * (b @ b))
    return float(a @ b / scale) if scale > 0.0 else 0.0


def _peak(found: Array, best: int) -> float:
    """Top of the parabola through three correlations, in steps from the middle one."""
    if not 0 < best < len(found) - 1:
        return 0.0
    before, here, after = found[best - 1 : best + 2]
    return float(0.5 * (before - after) / (before - 2.0 * here + after))


def _seconds(lag: float, time: Array, other_time: Array) -> float:
    return float(lag * GRID_S + other_time[0] - time[0])


def _error(first: Array, second: Array, lag: int) -> tuple[float, float]:
    """Standard error in s of a delay with fitted gain, for a residual with the memory of a first-order process."""
    a, b = _overlap(first, second, lag)
    gain, level = np.polyfit(a, b, 1)
    residual = b - gain * a - level
    memory = float(np.clip(_correlation(residual[1:], residual[:-1]), 0.0, 0.999))
    variance = residual.var() * (1.0 + memory) / (1.0 - memory)
    slope = np.gradient(gain * a, GRID_S)
    return float(np.sqrt(variance / (slope @ slope))), _correlation(a, b)
