"""Checks of single arguments of the environments: choices, numbers, flags, the rate of control."""

from __future__ import annotations

import math

import numpy as np

from jawenv.base.errors import InputError, not_among, shown
from jawenv.base.numeric_fields import real_number
from jawenv.controls import ControlMode
from jawenv.device.device import LAW_TICKS, TICK

LARGEST = 1e6  # of the numeric arguments


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
