"""Numbers from outside, NumPy's scalars among them, as Python's own."""

from __future__ import annotations

import math
import numbers


def real_number(value: object) -> float | None:
    """A finite real number as a float; None for anything else, such as a bool, a complex number, text or NaN."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def whole_number(value: object) -> int | None:
    """An integer as an int; None for anything else, such as a bool or 2.0."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        return None
    return int(value)
