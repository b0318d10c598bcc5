"""The spaces of the environments, and checks of arguments: choices, numbers, flags, the rate of control, actions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from jawenv.base.errors import InputError, not_among, shown
from jawenv.base.numeric_fields import real_number
from jawenv.controls import ControlMode
from jawenv.device.device import LAW_TICKS, N_MOTORS, TICK
from jawenv.envs.observation import OBSERVATION_BOUND

LARGEST = 1e6  # of the numeric arguments


def observation_space(size: int) -> Any:
    """The flat observation of one world; ``Parts`` say what lies where."""
    return spaces.Box(-OBSERVATION_BOUND, OBSERVATION_BOUND, (size,), np.float32)


def action_space() -> Any:
    """One number in [-1, 1] for each motor."""
    return spaces.Box(-1.0, 1.0, (N_MOTORS,), np.float32)


def check_choice(name: str, value: object, allowed: tuple[str, ...]) -> None:
    """One of the allowed names."""
    if not isinstance(value, str) or value not in allowed:
        raise not_among(name, value, allowed)


def checked_number(name: str, value: object, or_zero: bool = False) -> float:
    """A number more than 0, or also 0, and at most ``LARGEST``."""
    number = real_number(value)
    if number is None or not 0.0 <= number <= LARGEST or (number == 0.0 and not or_zero):
        low = "0 or more" if or_zero else "more than 0"
        raise InputError(f"{name} is {shown(value)}; allowed: a number, {low}, at most {LARGEST:g}")
    return number


def checked_flag(name: str, value: object) -> bool:
    """True or false, also NumPy's."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} is {shown(value)}; allowed: true or false")
    return bool(value)


def checked_rate(value: object, mode: ControlMode) -> float:
    """Control steps per second, of which each is a whole number of ticks, or of the law's steps."""
    hz, least = checked_number("control_hz", value), LAW_TICKS if mode.takes_targets else 1
    periods = 1.0 / hz / TICK / least
    if not math.isfinite(periods) or abs(periods - round(periods)) > 1e-9 or periods < 1.0:
        raise InputError(f"control_hz is {hz:g}; allowed: {1.0 / (least * TICK):g} divided by a whole number")
    return hz


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
