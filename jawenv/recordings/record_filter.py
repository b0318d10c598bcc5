"""The environments' own filter, run over a record."""

from __future__ import annotations

import numpy as np

from jawenv.base.errors import InputError
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.online import OnlineFilter
from jawenv.recordings.record import Record


class TensionFilter:
    """The filter of the environments: see ``state``.

    Args:
        every: Ticks from one belief to the next; 5 as in the environments at 20 Hz.
    """

    name = "tension filter"

    def __init__(self, *, every: int = 5) -> None:
        """Check the argument."""
        if every < 1:
            raise InputError(f"every is {every}; allowed: 1 or more")
        self.every = every

    def estimate(self, record: Record) -> Estimate:
        """The belief at the start and after every ``every`` ticks."""
        online, kept = OnlineFilter.of_record(record, every=self.every), []
        for tick, measured in enumerate(record.measured):
            belief = online.update(measured, record.samples[tick - 1] if tick > 0 else None)
            if tick % self.every == 0:
                kept.append((belief.log_mean, belief.log_cov))
        means, covs = map(np.array, zip(*kept, strict=True))
        return Estimate(self.name, record.time[:: self.every], means, covs)
