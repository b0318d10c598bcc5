"""The motion along which a bound or a sensitivity is computed, as the kernels read it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.filter.bound.joint_recursion import joint_scratch_dtype
from jawenv.filter.model.motion_step import set_muscles
from jawenv.kernels.records import record_zeros
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


class MotionPath(NamedTuple):
    """A known motion of T ticks, n states and p parameters, with what is known about noise."""

    jaw: Any  # the model, a record of dtype ``jaw_dtype``
    muscles: Array  # (lines, 2) F_o (N) and b of each line along the motion
    states: Array  # (T + 1, n) motion at the ticks' ends
    wrenches: Array  # (T, 3, 6) wrench on the mouthpiece at start, middle and end of each tick
    samples: Array  # (T, 3, 6) what the load cell read of them; its trend is what the gain error multiplies
    used: NDArray[np.uint8]  # (T + 1, 12) uint8, which encoder values were read
    covariance: Array  # (n + p + 1, n + p + 1) before the first measurement: motion, parameters, gain error
    measurement_variance: Array  # (12,)
    noise_variance: Array  # (12,) of the wrench not known, new in each tick: constant over it, and tilting
    dt: float  # s
    scratch: Any  # working memory of the filter's kernels


def path_of(record: Record, parameters: Array | None = None) -> MotionPath:
    """The path of a record's true motion; of a device's own record, of the motion that was put in for it.

    Args:
        record: with ``states``. Without ``wrenches`` the load cell's samples stand for them.
        parameters: (p,) natural-log parameters; None for the record's ``truth``.
    """
    record.require_exact("bound or analysis along a path")
    if record.states is None:
        raise InputError("record: states is None; allowed: a record with the true motion, or with an estimate of it")
    values = record.truth if parameters is None else np.asarray(parameters, dtype=np.float64)
    size = len(record.parameter_names)
    if values is None:
        raise InputError(f"parameters is None, and the record has no truth; allowed: {size} log-parameters")
    if np.shape(values) != (size,) or not np.isfinite(values).all():
        raise InputError(f"parameters is {values}; allowed: {size} finite natural-log parameters")
    jaw, motion = record.jaw, record.states.shape[1]
    scratch = record_zeros(1, joint_scratch_dtype(size // 2, len(jaw["muscle"]), motion))[0]
    muscles = np.zeros((len(jaw["muscle"]), 2))
    set_muscles(jaw, values, muscles)
    return MotionPath(
        jaw=jaw,
        muscles=muscles,
        states=np.ascontiguousarray(record.states),
        wrenches=np.ascontiguousarray(record.samples if record.wrenches is None else record.wrenches),
        samples=np.ascontiguousarray(record.samples),
        used=np.isfinite(record.measured).astype(np.uint8),
        covariance=np.diag(np.concatenate([record.start_sd, record.prior.sd, [record.gain_sd]]) ** 2),
        measurement_variance=record.measurement_sd**2,
        noise_variance=record.noise_variance,
        dt=record.dt,
        scratch=scratch,
    )
