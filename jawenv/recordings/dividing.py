"""A slow recording with short ticks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


def divided(record: Record, parts: int) -> Record:
    """A slow device's recording with short ticks: each tick divided into equal ones, the encoders unread in between.

    A filter models the unmodelled wrench and the load cell's noise as constant over a tick. Where they change faster
    than the recording is sampled, ticks of their correlation time (10 ms, ``defaults.UNMODELLED_TIME``) keep the filter
    calibrated: see ``thinning``. The load cell's samples are read off each tick's parabola; ``wrench_sd`` and
    ``cell_sd`` rise with the root of ``parts``. Estimators that differentiate the motion need every reading, and refuse
    such a record.

    Args:
        record: of T ticks.
        parts: >= 1; the result has T times as many ticks. Its true states and wrenches between are not known.
    """
    if isinstance(parts, bool) or not isinstance(parts, int | np.integer) or parts < 1:
        raise InputError(f"divided: parts is {parts!r}; allowed: a whole number from 1 on")
    if parts == 1:
        return record
    ticks = len(record.samples)
    measured = np.full((ticks * parts + 1, record.measured.shape[1]), np.nan)
    measured[::parts] = record.measured
    share = (np.arange(parts)[:, None] + np.array([0.0, 0.5, 1.0])) / parts
    samples = np.einsum("pos,tsk->tpok", parabola(share), record.samples).reshape(-1, 3, record.samples.shape[-1])
    return replace(
        record,
        time=np.linspace(record.time[0], record.time[-1], ticks * parts + 1),
        measured=measured,
        samples=samples,
        wrench_sd=record.wrench_sd * np.sqrt(parts),
        cell_sd=record.cell_sd * np.sqrt(parts),
        states=None,
        wrenches=None,
    )


def parabola(share: Array) -> Array:
    """(..., 3) weights of the samples at start, middle and end in the parabola through them, at a share of the tick."""
    ends = (1.0 - share) * (1.0 - 2.0 * share), share * (2.0 * share - 1.0)
    return np.stack([ends[0], 4.0 * share * (1.0 - share), ends[1]], axis=-1)
