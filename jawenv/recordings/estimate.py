"""A belief about the parameters over time: what every estimator makes of a record, by ``estimate``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError

Array = NDArray[np.float64]


ENOUGH = 0.05
"""Error bar of a natural log at which a recording may stop: 5 %."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """An estimator's belief about p natural-log parameters at K times."""

    name: str  # of the estimator
    time: Array  # (K,) s; a method that looks at the whole record at once has only the last
    mean: Array  # (K, p)
    cov: Array  # (K, p, p)

    def __post_init__(self) -> None:
        """Check the shapes against each other."""
        times, parameters = np.shape(self.mean) if np.ndim(self.mean) == 2 else (0, 0)
        for field, shape in (("time", (times,)), ("cov", (times, parameters, parameters))):
            if times < 1 or np.shape(getattr(self, field)) != shape:
                raise InputError(f"estimate: {field} has shape {np.shape(getattr(self, field))}; allowed: {shape}")

    @property
    def sd(self) -> Array:
        """(K, p) standard deviations, so 0.05 is 5 %."""
        return np.sqrt(np.diagonal(self.cov, axis1=-2, axis2=-1))
