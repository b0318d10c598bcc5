"""Distribution of the two numbers of a muscle, of which cohorts are made."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import real_number


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
