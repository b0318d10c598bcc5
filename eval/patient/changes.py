"""How much the muscles have changed since the first treatment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eval import words
from eval.patient.charts import SD_95
from eval.patient.shared import change
from eval.patient.treatments import Treatment
from jawenv.anatomy import Prior

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Change:
    """How much each parameter has changed since the first treatment, as natural logs.

    Attributes:
        mean: (P,).
        sd: (P,).
    """

    mean: Array
    sd: Array

    def of(self, parameter: int) -> tuple[float, float, float]:
        """The factor by which a parameter has changed, and the ends of its 95 % interval."""
        value, reach = self.mean[parameter], SD_95 * self.sd[parameter]
        return math.exp(value), math.exp(value - reach), math.exp(value + reach)


def change_of(course: Sequence[Treatment], prior: Prior) -> Change | None:
    """The change from the first treatment to the last; None of one, or where the anatomy is known exactly.

    Args:
        course: treatments of a patient.
        prior: of the muscles.
    """
    first, last = course[0].told, course[-1].told
    if len(course) == 1 or first is None or last is None:
        return None
    mean, cov = change(first, last, prior)
    return Change(mean, np.sqrt(np.diagonal(cov)))


def change_in_words(factor: float, low: float, high: float) -> str:
    """As `softer by 20 % (12 … 27)`: a factor with the ends of its interval."""
    word, sign = ("softer", -1.0) if factor < 1.0 else ("stiffer", 1.0)
    value, *ends = (100.0 * sign * (each - 1.0) for each in (factor, low, high))
    low, high = sorted(ends)
    return f"{word} by {words.number(value, 0)} % ({words.number(low, 0)} … {words.number(high, 0)})"
