"""What a whole record says of the parameters, the motion integrated out and nothing linearised at an early guess.

The record is filtered as if the muscles were known, and the belief is made at its end; then again about that belief,
until it stays (``replay``). Where readings leave the pose open, as those of one point do, more than one belief may
stay, as least squares have more than one minimum: several starts are followed, and the belief is the sum of what they
come to (``mixture``). Where they do not, the path's parameters are the only start.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.estimation.online.record_filter import FilterRun, filter_record
from jawenv.estimation.online.replay import N_STARTS, PASSES, search, set_starts
from jawenv.estimation.recordings.record import Record

Array = NDArray[np.float64]

SMALL_STEP = 0.01  # sds, of a pass that ends the search


def integrate_out(record: Record, found: Array) -> tuple[Array, Array]:
    """Mean (p,) and covariance (p, p) of the natural-log parameters.

    Args:
        record: the record.
        found: (p,) where to begin; where the pose is left open, also where the filter ends and what
            ``replay.set_starts`` makes of that.
    """
    run = FilterRun(record)
    jaw, device, belief, rows, settings, scratch = run.arguments
    starts = found[None].copy()
    if settings["pose_open"]:
        kept = np.empty((1, len(found))), np.empty((1, len(found), len(found)))
        filter_record(*run.arguments, len(rows), *kept)
        starts = np.vstack([starts, np.empty((N_STARTS, len(found)))])
        starts = starts[: 1 + set_starts(belief, settings, starts[1:])]
    search(jaw, device, belief, rows, run.last, settings, scratch, starts, PASSES, SMALL_STEP)
    return belief["mean"].copy(), belief["cov"].copy()
