"""The filter's belief before the first measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.base.errors import InputError

__all__ = ["Prior"]


@dataclass(frozen=True, eq=False)
class Prior(FrozenArrays):
    """Independent normal beliefs about the natural-log parameters."""

    mean: NDArray[np.float64]  # (p,) in the order of the parameters' names
    sd: NDArray[np.float64]  # (p,) standard deviations, so 0.05 is 5 %

    def __post_init__(self) -> None:
        """Check shapes and signs."""
        super().__post_init__()
        if np.ndim(self.mean) != 1:
            raise InputError(f"prior mean has shape {np.shape(self.mean)}; allowed: one axis")
        self._require_shape("sd", np.shape(self.mean))
        for i, sd in enumerate(self.sd):
            if sd <= 0:
                raise InputError(f"prior sd of parameter {i} is {sd}; allowed: numbers above 0")
