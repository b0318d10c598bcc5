"""The environments' own filter, run over a record."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.filter.belief.state import belief_dtype
from jawenv.filter.learn import conclude
from jawenv.filter.tick import ROW, begin_filter, filter_scratch_dtype, filter_tick, read_row
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import record_zeros
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.filter_settings import settings_of_record
from jawenv.recordings.online import OnlineFilter
from jawenv.recordings.record import Record

Array = NDArray[np.float64]


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
        times, size = record.time[:: self.every], len(record.prior.mean)
        mean, cov = np.empty((len(times), size)), np.empty((len(times), size, size))
        if record.exact:
            filter_record(FilterRun(record).arguments, self.every, mean, cov)
        else:
            self._update_through(record, mean, cov)
        return Estimate(self.name, times, mean, cov)

    def _update_through(self, record: Record, means: Array, covs: Array) -> None:
        """The same, tick by tick: the kernels of nuisances are compiled for the online filter alone."""
        online = OnlineFilter.of_record(record, every=self.every)
        for tick, measured in enumerate(record.measured):
            belief = online.update(measured, record.samples[tick - 1] if tick > 0 else None)
            if tick % self.every == 0:
                means[tick // self.every], covs[tick // self.every] = belief.log_mean, belief.log_cov


class Arguments(NamedTuple):
    """Arguments of the kernels that filter a record; the dtypes are in ``tick`` and ``state``."""

    jaw: Any  # the model
    belief: Any  # state of the filter, before the first reading
    kept: Any  # the same, as the last replay left it
    rows: Any  # (T + 1,) the readings
    settings: Any  # of dtype ``filter_settings_dtype``
    scratch: Any  # working memory


class FilterRun:
    """The kernels' inputs for the filter of a record: the jaw, and memory as before the first reading.

    Args:
        record: the record.

    Attributes:
        arguments: as the kernels take them.
        last: number of the last row.
        settings: those among the arguments.
    """

    def __init__(self, record: Record) -> None:
        """Make the arrays; the belief is the prior."""
        record.require_exact("FilterRun")
        states, muscles = len(record.start_mean), len(record.parameter_names) // 2
        settings = settings_of_record(record)
        rows: Any = record_zeros(len(record.time), ROW)
        rows["measured"], rows["samples"][1:] = record.measured, record.samples
        self.settings, self.last = settings, len(rows) - 1
        self.belief, kept = record_zeros(2, belief_dtype(muscles, states))
        scratch = record_zeros(1, filter_scratch_dtype(muscles, len(record.jaw["l_o"]), states))[0]
        begin_filter(record.jaw, self.belief, record.start_mean, settings)
        self.arguments = Arguments(record.jaw, self.belief, kept, rows, settings, scratch)


@njit
def filter_record(run: Arguments, every, means, covs):
    """Run the filter over all rows of ``Arguments``; after every ``every`` ticks the belief goes to the arrays."""
    belief, rows, settings, scratch = run.belief, run.rows, run.settings, run.scratch
    begin_filter(run.jaw, belief, belief.began, settings)
    for tick in range(rows.shape[0]):
        measured, samples = read_row(rows[tick], scratch)
        filter_tick(run.jaw, (belief, run.kept), rows, tick, measured, samples, settings, scratch)
        if tick % every == 0:
            conclude(belief, settings, scratch.belief)
            means[tick // every] = belief.mean
            covs[tick // every] = belief.cov
