"""A recording as a slower device would have made it: fewer, longer ticks, or the same ticks with fewer readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError
from jawenv.estimation.record import Record

Array = NDArray[np.float64]


def thinned(record: Record, every: int) -> Record:
    """Every ``every``-th reading of the encoders; ticks at the end that do not make a whole longer one are left out.

    The load cell does not sample at a few instants, which would alias, but averages, as the amplifier of a slow one
    does: its three numbers of a longer tick are of the parabola that fits all readings in it best (least squares) and
    has their mean and first two moments. So ``wrench_sd`` and ``cell_sd`` both fall with the root of ``every``, as the
    mean of what is new in each short tick does.

    A filter on the longer ticks is too sure of itself all the same. It takes the wrench that is not known as constant
    over a tick, while that of the simulated device changes every 10 ms: in 50 ms a stiff jaw may swing a whole period,
    over which a constant wrench hardly changes its velocity and a changing one does. At 20 Hz true motions depart from
    the model's by up to 3.9 of its sds (root mean square, forward speed of the condyle), and by 0.9 to 1.0 where the
    wrench is taken as new every 10 ms. Finer integration, or load-cell noise that does not fall, changes little.

    Median NEES of 12 parameters (honest: 11.3) and median error of the plain extended Kalman filter in logs, maneuver
    ``opening_with_swings_and_fore_aft``, 24 patients of cohort ``trismus``, seeds from 10000, 15 s:

    ========  ============  ==================  ===================
    readings  ``thinned``   three instants      ``read_every``
    ========  ============  ==================  ===================
    100 Hz    8.9, 3.3 %    8.9, 3.3 %          8.9, 3.3 %
    50 Hz     12.8, 4.8 %   13.8, 4.0 %         7.0, 2.9 %
    20 Hz     194, 12 %     449, 16 %           9.8, 4.1 %
    10 Hz     971, 26 %     6961, 58 %          12.8, 6.1 %
    ========  ============  ==================  ===================

    In the second column the load cell is read at start, middle and end of each longer tick only. The environments' own
    filter has 10.0, 20 and 261 at 100, 50 and 20 Hz on ``thinned`` records, and 10.0, 11.1 and 19.8 with
    ``read_every``.

    Args:
        record: of T ticks.
        every: 1 to T.

    Raises:
        InputError: ``every`` is not a whole number from 1 to T.
    """
    last = _whole(record, every)
    rows = slice(0, last + 1, every)
    return replace(
        record,
        time=record.time[rows],
        measured=record.measured[rows],
        samples=_of_longer_ticks(record.samples[:last], every),
        wrench_sd=record.wrench_sd / np.sqrt(every),
        cell_sd=record.cell_sd / np.sqrt(every),
        states=None if record.states is None else record.states[rows],
        wrenches=None if record.wrenches is None else _of_longer_ticks(record.wrenches[:last], every),
    )


def read_every(record: Record, every: int) -> Record:
    """The same ticks, in which the encoders are read at the first and every ``every``-th time after it only.

    The load cell stays as fast as it is, and so do the steps of a filter, which therefore stays honest where one on
    ``thinned`` ticks does not. Estimators that differentiate the motion need every reading, and refuse such a record.

    Args:
        record: of T ticks.
        every: 1 to T.

    Raises:
        InputError: ``every`` is not a whole number from 1 to T.
    """
    _whole(record, every)
    measured = np.full_like(record.measured, np.nan)
    measured[::every] = record.measured[::every]
    return replace(record, measured=measured)


def _whole(record: Record, every: int) -> int:
    """How many of the ticks make whole longer ones."""
    ticks = len(record.samples)
    if isinstance(every, bool) or not isinstance(every, int | np.integer) or not 1 <= every <= ticks:
        raise InputError(f"thinned: every is {every!r}, allowed is a whole number from 1 to {ticks}")
    return ticks - ticks % int(every)


def _of_longer_ticks(samples: Array, every: int) -> Array:
    """(T / every, 3, 6) samples of the parabola that fits those of each group of ``every`` ticks best.

    Each tick's three samples stand for a parabola too. The integrals are exact: three points of Gauss and Legendre do
    for the product of two parabolas. A frozen load cell stays the same number to the bit, so that it is recognised.
    """
    if every == 1:
        return samples.copy()
    nodes, weights = np.polynomial.legendre.leggauss(3)
    share = 0.5 * (nodes + 1.0)
    read = np.column_stack(
        [(1.0 - share) * (1.0 - 2.0 * share), 4.0 * share * (1.0 - share), share * (2.0 * share - 1.0)]
    )
    place = (np.arange(every)[:, None] + share) / every
    moments = np.einsum("egm,g,gs->mes", _legendre(place), 0.5 * weights / every, read)
    to_samples = np.einsum("om,mes->oes", _legendre(np.array([0.0, 0.5, 1.0])), moments)
    groups = samples.reshape(-1, every, 3, samples.shape[-1])
    found = np.einsum("oes,tesk->tok", to_samples, groups)
    frozen = np.ptp(groups, axis=(1, 2)) == 0.0
    return np.where(frozen[:, None], groups[:, 0, :1], found)


def _legendre(share: Array) -> Array:
    """(..., 3) orthonormal polynomials on 0 to 1."""
    x = 2.0 * share - 1.0
    return np.stack([np.ones_like(x), np.sqrt(3.0) * x, np.sqrt(1.25) * (3.0 * x**2 - 1.0)], axis=-1)
