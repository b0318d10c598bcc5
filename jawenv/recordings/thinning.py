"""A recording as a slower device would have made it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.recordings.dividing import parabola
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


def thinned(record: Record, every: int) -> Record:
    """Every ``every``-th reading of the encoders; ticks at the end that make no whole longer one are left out.

    The load cell does not sample at a few instants, which would alias, but averages, as the amplifier of a slow one
    does: its three numbers of a longer tick are of the parabola that fits all readings in it best (least squares) and
    has their mean and first two moments. So ``wrench_sd`` and ``cell_sd`` both fall with the root of ``every``, as the
    mean of what is new in each short tick does.

    A filter on the longer ticks is overconfident all the same. It models the unmodelled wrench and the load cell's
    noise as constant over a tick, while they change every 10 ms or less: in 50 ms a stiff jaw may swing a whole period,
    over which a constant wrench hardly changes its velocity and a changing one does.

    Median NEES of 12 parameters (calibrated: 11.3) and median error of the plain extended Kalman filter in logs,
    maneuver ``opening_with_swings_and_fore_aft``, 24 patients of cohort ``trismus``, seeds from 10000, 15 s:

    ========  ============  ========================
    readings  ``thinned``   ``thinned``, ``divided``
    ========  ============  ========================
    100 Hz    8.7, 3.3 %    8.7, 3.3 %
    50 Hz     11.2, 3.8 %   6.9, 2.8 %
    20 Hz     35.6, 6.9 %   9.8, 4.2 %
    10 Hz     178, 14 %     12.0, 4.9 %
    ========  ============  ========================

    What the environments' own filter makes of ``divided`` records, ``examples/slow_device.py`` prints.

    Args:
        record: of T ticks.
        every: 1 to T.
    """
    last = _whole_ticks(record, every)
    rows = slice(0, last + 1, every)
    return replace(
        record,
        time=record.time[rows],
        measured=record.measured[rows],
        samples=_longer_ticks(record.samples[:last], every),
        wrench_sd=record.wrench_sd / np.sqrt(every),
        cell_sd=record.cell_sd / np.sqrt(every),
        states=None if record.states is None else record.states[rows],
        wrenches=None if record.wrenches is None else _longer_ticks(record.wrenches[:last], every),
    )


def _whole_ticks(record: Record, every: int) -> int:
    """Number of the ticks that make whole longer ones."""
    ticks = len(record.samples)
    if isinstance(every, bool) or not isinstance(every, int | np.integer) or not 1 <= every <= ticks:
        raise InputError(f"thinned: every is {every!r}; allowed: a whole number from 1 to {ticks}")
    return ticks - ticks % int(every)


def _longer_ticks(samples: Array, every: int) -> Array:
    """(T / every, 3, 6) samples of the parabola that fits those of each group of ``every`` ticks best.

    Each tick's three samples stand for a parabola too. The integrals are exact: three points of Gauss and Legendre do
    for the product of two parabolas. A frozen load cell stays the same number to the bit, so that it is recognised.
    """
    if every == 1:
        return samples.copy()
    nodes, weights = np.polynomial.legendre.leggauss(3)
    share = 0.5 * (nodes + 1.0)
    sample_weights = parabola(share)
    position = (np.arange(every)[:, None] + share) / every
    moments = np.einsum("egm,g,gs->mes", _legendre(position), 0.5 * weights / every, sample_weights)
    to_samples = np.einsum("om,mes->oes", _legendre(np.array([0.0, 0.5, 1.0])), moments)
    groups = samples.reshape(-1, every, 3, samples.shape[-1])
    fitted = np.einsum("oes,tesk->tok", to_samples, groups)
    frozen = np.ptp(groups, axis=(1, 2)) == 0.0
    return np.where(frozen[:, None], groups[:, 0, :1], fitted)


def _legendre(share: Array) -> Array:
    """(..., 3) orthonormal polynomials on 0 to 1."""
    x = 2.0 * share - 1.0
    return np.stack([np.ones_like(x), np.sqrt(3.0) * x, np.sqrt(1.25) * (3.0 * x**2 - 1.0)], axis=-1)
