"""Beliefs that may be acted on: no replay of the readings is about to move them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.tick import MOVED

MOVED_SDS = 2.0
LEARNT_S = 0.5
"""Seconds of readings that teach something before which no belief is settled."""


def settled(moved: NDArray[np.float64], sd: NDArray[np.float64], learnt_s: object) -> NDArray[np.bool_]:
    """Whether beliefs may be acted on: a false one has mostly moved far, and is filtered again from there soon.

    Args:
        moved: (..., P) means of the natural logs less those at which the readings were last filtered again.
        sd: (..., P).
        learnt_s: (...) s of readings that teach something.

    Returns:
        (...).
    """
    near = (np.abs(moved) <= np.maximum(MOVED, MOVED_SDS * sd)).all(axis=-1)
    return np.asarray(near & (np.asarray(learnt_s) >= LEARNT_S))
