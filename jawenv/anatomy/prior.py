"""Distributions of the parameters: the filter's belief before the first measurement, and a cohort's of a muscle."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import real_number

__all__ = ["Prior", "Stiffness"]


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


@dataclass(frozen=True)
class Stiffness:
    """Log-normal distribution of the two numbers of a muscle."""

    F_o_N: float  # median force at the closed-jaw length, N
    F_o_sd: float  # sd of its natural log
    b: float  # median stiffness exponent
    b_sd: float  # sd of its natural log

    def __post_init__(self) -> None:
        """Check that the logarithms exist."""
        for name in (entry.name for entry in fields(self)):
            value = getattr(self, name)
            number = real_number(value)
            if number is None or number <= 0:
                raise InputError(f"{name} is {shown(value)}; allowed: finite numbers above 0")
            object.__setattr__(self, name, number)

    def log_mean(self) -> tuple[float, float]:
        """Means of log F_o and log b."""
        return math.log(self.F_o_N), math.log(self.b)

    def log_sd(self) -> tuple[float, float]:
        """Their standard deviations, before truncation."""
        return self.F_o_sd, self.b_sd

    def together(self, other: Stiffness) -> Stiffness:
        """A muscle of the sagittal plane, per whole muscle: mean force, mean logarithms of the rest."""
        return Stiffness(
            0.5 * (self.F_o_N + other.F_o_N),
            0.5 * (self.F_o_sd + other.F_o_sd),
            math.sqrt(self.b * other.b),
            0.5 * (self.b_sd + other.b_sd),
        )

    def times(self, factor: float) -> Stiffness:
        """The same with a force larger by a factor."""
        return Stiffness(factor * self.F_o_N, self.F_o_sd, self.b, self.b_sd)

    def widened(self, factor: float) -> Stiffness:
        """The same medians with sds larger by a factor."""
        return Stiffness(self.F_o_N, factor * self.F_o_sd, self.b, factor * self.b_sd)
