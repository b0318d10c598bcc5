"""What the filter believes before the first measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.anatomy.muscles import PARAMETER_NAMES
from jawenv.errors import InputError

__all__ = ["Prior"]


@dataclass(frozen=True, eq=False)
class Prior(FrozenArrays):
    """Independent normal beliefs about the natural-log parameters.

    Attributes:
        mean: (12,) in the order of `PARAMETER_NAMES`.
        sd: (12,) standard deviations, so 0.05 is 5 %.

    Raises:
        InputError: wrong shape, not finite, or an sd that is not positive.
    """

    mean: NDArray[np.float64]
    sd: NDArray[np.float64]

    def __post_init__(self) -> None:
        """Check shapes and signs."""
        super().__post_init__()
        for name in ("mean", "sd"):
            self._require_shape(name, (len(PARAMETER_NAMES),))
        for parameter, sd in zip(PARAMETER_NAMES, self.sd, strict=True):
            if sd <= 0:
                raise InputError(f"prior sd of {parameter} = {sd} must be greater than 0")
