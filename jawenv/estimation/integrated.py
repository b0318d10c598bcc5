"""What a whole record says of the parameters, the motion integrated out and nothing linearised at an early guess.

The record is filtered as if the muscles were known, and the belief is made at its end (``online.belief_about``); then
again about that belief, until it stays. Where readings leave the pose open, as those of one point do, more than one
belief may stay, as least squares have more than one minimum: of several starts, the belief that fits the readings best
is taken.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.estimation.extended_kalman import run_filter
from jawenv.estimation.initial import initial_belief
from jawenv.estimation.measurement import N_MEASUREMENTS, expect
from jawenv.estimation.online import belief_about
from jawenv.estimation.record import Record

Array = NDArray[np.float64]

PASSES = 10  # at most, over a record, until one moves no parameter by
SMALL_STEP = 0.01  # sds or more
SHORTEST = 5  # ticks of a growing record
PASSES_WHILE_GROWING = 2


def integrate_out(record: Record, found: Array) -> tuple[Array, Array]:
    """Mean (p,) and covariance (p, p) of the natural-log parameters.

    Args:
        record: the record.
        found: (p,) where to begin, besides the prior's mean and what the record says as it grows.
    """
    beliefs = [_settle(record, start, PASSES) for start in (found, record.prior.mean, _grown(record))]
    misfits = [_misfit(record, mean) for mean, _ in beliefs]
    return beliefs[int(np.nanargmin(misfits))] if np.isfinite(misfits).any() else beliefs[0]


def _settle(record: Record, mean: Array, passes: int) -> tuple[Array, Array]:
    """The belief about ``mean``, about that belief, and so on."""
    for _ in range(passes):
        before = mean
        mean, cov = belief_about(record, before)
        if (np.abs(mean - before) < SMALL_STEP * np.sqrt(np.diag(cov))).all():
            break
    return mean, cov


def _grown(record: Record) -> Array:
    """Mean of the belief about records that grow, each linearised about the last: no step is a long one."""
    mean, ticks = record.prior.mean, SHORTEST
    while ticks < len(record.samples):
        mean, _ = _settle(record.until(ticks * record.dt), mean, PASSES_WHILE_GROWING)
        ticks *= 2
    return mean


def _misfit(record: Record, parameters: Array) -> float:
    """Half the squared misfit of readings and prior, in sds, along the motion filtered with these parameters."""
    states = len(record.start_mean)
    mean, covariance = initial_belief(record)
    mean[states:-1] = parameters
    known = np.diag(np.where(np.arange(len(mean)) < states, np.diag(covariance), 0.0))
    no_noise = np.zeros((len(record.samples), len(parameters)))
    means, _ = run_filter(record, mean, known, no_noise, np.empty(0, dtype=np.int64))
    rows, expected = np.empty((N_MEASUREMENTS, states)), np.empty((len(means), N_MEASUREMENTS))
    for state, readings in zip(means[:, :states], expected, strict=True):
        expect(record.jaw, state, rows, readings)
    sds = (record.measured - expected) / record.measurement_sd
    away = (parameters - record.prior.mean) / record.prior.sd
    return float(0.5 * np.nansum(sds**2) + 0.5 * np.sum(away**2)) if np.isfinite(means).all() else np.nan
