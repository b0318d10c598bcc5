"""The environments' own filter, run over a record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from jawenv.recordings.estimate import Estimate
from jawenv.recordings.online import OnlineFilter
from jawenv.recordings.record import Record


@dataclass(frozen=True)
class TensionFilter:
    """The filter of the environments: see ``state``."""

    name: ClassVar[str] = "tension filter"
    every: int = 5  # ticks from one belief to the next, as in the environments at 20 Hz

    def estimate(self, record: Record) -> Estimate:
        """The belief at the start and after every ``every`` ticks."""
        online, kept = OnlineFilter.of_record(record, every=self.every), []
        for tick, measured in enumerate(record.measured):
            belief = online.update(measured, record.samples[tick - 1] if tick > 0 else None)
            if tick % self.every == 0:
                kept.append((belief.log_mean, belief.log_cov))
        means, covs = map(np.array, zip(*kept, strict=True))
        return Estimate(self.name, record.time[:: self.every], means, covs)
