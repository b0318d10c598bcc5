"""Mean and spread of a parameter's estimates over the draws, as the thesis reads them off its histograms."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from eval.figures import words


@dataclass(frozen=True)
class Spread:
    """One parameter, F_o (N) or b, over all draws; NaN where there are too few."""

    parameter: str  # its name
    truth: float  # its true value
    mean: float  # of the estimates
    sd: float  # of the estimates

    @property
    def bias(self) -> float:
        """Relative: 0.1 is a mean 10 % too large."""
        return self.mean / self.truth - 1.0

    @property
    def bias_sds(self) -> float:
        """Bias in sds of a single estimate."""
        return (self.mean - self.truth) / self.sd if self.sd > 0.0 else float("nan")

    @property
    def relative_sd(self) -> float:
        """Sd over the truth."""
        return self.sd / self.truth

    @property
    def inside(self) -> bool:
        """Whether the truth lies within one sd of the mean."""
        return abs(self.mean - self.truth) <= self.sd

    @property
    def is_force(self) -> bool:
        """Whether it is F_o."""
        return self.parameter.startswith("log_F_o/")

    def text(self, digits: int = 2) -> str:
        """The spread in words, such as `b masseter 7.95 ± 0.90 for 8.00`."""
        symbol = "F_o" if self.is_force else "b"
        values = [words.number(value, digits) for value in (self.mean, self.sd, self.truth)]
        return f"{symbol} {words.muscle(self.parameter)} {values[0]} ± {values[1]} for {values[2]}"


def spreads(table: pd.DataFrame) -> list[Spread]:
    """The spread of every parameter, over the values at hand."""
    estimates = []
    for name in dict.fromkeys(map(str, table["parameter"])):
        rows = table[table["parameter"] == name]
        values = rows["value"].dropna()
        estimates.append(
            Spread(name, float(rows["true_value"].iloc[0]), float(values.mean()), float(values.std(ddof=1)))
        )
    return estimates
