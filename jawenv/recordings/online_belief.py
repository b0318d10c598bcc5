"""What a filter in a device's loop believes after a tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jawenv.recordings.estimate import ENOUGH, Array


@dataclass(frozen=True, eq=False)
class OnlineBelief:
    """The belief after a tick about p parameters, whose natural logs are normal."""

    names: tuple[str, ...]  # p names, as ``log_F_o/masseter_left``
    time_s: float  # of the tick's end, from the first reading
    log_mean: Array  # (p,) mean of the natural logs
    log_cov: Array  # (p, p) their covariance
    misfit: float
    """The alarm, above 1 where no parameters explain the readings, or the belief moves by more than it claims."""
    gated: int  # ticks so far whose readings were refused
    left_out: int  # readings of this tick that were missing, out of range or frozen
    learnt: int  # ticks so far from which something was learnt: at the teeth nothing is
    settled: bool  # whether the belief may be acted on, see ``jawenv.filter.settled``

    @property
    def log_sd(self) -> Array:
        """(p,) sd of the natural logs, so 0.05 is 5 %."""
        sd: Array = np.sqrt(np.diagonal(self.log_cov))
        return sd

    @property
    def enough(self) -> bool:
        """Whether the device may stop: every error bar is within 5 %."""
        return bool((self.log_sd <= ENOUGH).all())

    @property
    def mean(self) -> Array:
        """(p,) mean of F_o in N and of b, which has no unit."""
        mean: Array = np.exp(self.log_mean + 0.5 * np.diagonal(self.log_cov))
        return mean

    @property
    def sd(self) -> Array:
        """(p,) sd of F_o in N and of b."""
        sd: Array = self.mean * np.sqrt(np.expm1(np.diagonal(self.log_cov)))
        return sd
