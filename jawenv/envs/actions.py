"""Actions from outside, checked."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown
from jawenv.device.device import N_MOTORS

SLACK = 1e-6  # single-precision policies overshoot their bounds by rounding


def checked_action(action: Any) -> NDArray[np.float64]:
    """``checked_actions`` of one world: (1, 4)."""
    if type(action) is np.ndarray and action.shape == (N_MOTORS,) and action.dtype.kind == "f":
        a, b, c, d = action.tolist()
        if -1.0 <= a <= 1.0 and -1.0 <= b <= 1.0 and -1.0 <= c <= 1.0 and -1.0 <= d <= 1.0:
            return action.astype(np.float64).reshape(1, N_MOTORS)
    return checked_actions(action, (N_MOTORS,)).reshape(1, N_MOTORS)


def checked_actions(actions: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """``actions`` as a float array of ``shape`` within [-1, 1]."""
    try:
        values = np.asarray(actions)
        # A complex array would lose its imaginary part, and text that looks like numbers would pass for numbers.
        array = values.astype(np.float64) if actions is not None and values.dtype.kind not in "cSU" else None
    except (TypeError, ValueError):
        array = None
    if array is None:
        raise InputError(f"action is {shown(actions)}; allowed: numbers of shape {shape}")
    if array.shape != shape:
        raise InputError(f"action has shape {array.shape}; allowed: {shape}")
    wrong = ~(np.abs(array) <= 1.0 + SLACK)
    if wrong.any():
        index = tuple(int(i) for i in np.argwhere(wrong)[0])
        where = ", ".join(map(str, index))
        raise InputError(f"action[{where}] is {array[index]}; allowed: -1 to 1")
    clipped: NDArray[np.float64] = np.clip(array, -1.0, 1.0)
    return clipped
