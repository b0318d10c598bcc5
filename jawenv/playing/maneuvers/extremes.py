"""The least and the greatest value of a sum of sines over a time, by branch and bound.

Nothing between samples is missed.
"""

import numpy as np

from jawenv.playing.protocol import Array

EXACT_TO = 1e-6
"""By how much a bound may lie outside of the true extreme, for amplitudes whose sum is about 1."""
_MOST_SINES = 2_000_000  # that are evaluated for one bound
_CELLS_AT_ONCE = 50_000


def extremes(amplitude: Array, omega: Array, phase: Array, duration_s: float) -> tuple[float, float]:
    """Bounds of the sum over k of ``amplitude[k] sin(omega[k] t + phase[k])`` for t from 0 to ``duration_s``.

    In a cell of half width h about its middle m, the sum f is at most f(m) + |f'(m)| h + c h^2 / 2, where c is the sum
    of ``|amplitude| omega^2``. Cells that may hold more than the greatest value seen are halved. Where that would take
    long, the bounds are those of the cells so far, or the sum of the amplitudes: never too narrow.

    Args:
        amplitude: (K,), any unit.
        omega: angular frequencies (K,), rad/s.
        phase: (K,), rad.
        duration_s: greater than 0.

    Returns:
        A lower bound of the least value and an upper bound of the greatest one, within ``EXACT_TO`` of it but for many
        quick sines.
    """
    greatest = _greatest(amplitude, omega, phase, duration_s)
    return -_greatest(-amplitude, omega, phase, duration_s), greatest


def _greatest(amplitude: Array, omega: Array, phase: Array, duration_s: float) -> float:
    bound = float(np.abs(amplitude).sum())
    curvature = float(np.abs(amplitude) @ omega**2)
    cells = int(np.ceil(duration_s * max(1.0, 2.0 * float(omega.max()) / np.pi)))  # four to a period of the quickest
    half = 0.5 * duration_s / cells
    if cells > _MOST_SINES:
        return bound
    middles: Array = (2.0 * np.arange(cells, dtype=np.float64) + 1.0) * half
    seen, sines = -np.inf, len(omega) * cells
    while sines <= _MOST_SINES:
        upper = np.empty(len(middles))
        for first in range(0, len(middles), _CELLS_AT_ONCE):
            some = slice(first, first + _CELLS_AT_ONCE)
            angle = np.multiply.outer(middles[some], omega) + phase
            value = np.sin(angle) @ amplitude
            slope = np.cos(angle) @ (amplitude * omega)
            seen = max(seen, float(value.max()))
            upper[some] = value + np.abs(slope) * half + 0.5 * curvature * half**2
        # Cells that were left out hold at most seen + EXACT_TO.
        bound = min(bound, max(float(upper.max()), seen + EXACT_TO))
        if upper.max() <= seen + EXACT_TO:
            break
        middles = middles[upper > seen + EXACT_TO]
        half *= 0.5
        middles = np.concatenate([middles - half, middles + half])
        sines += len(omega) * len(middles)
    return bound
