"""Identification of a recording by the environments' filter, with the reasons to doubt it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jawenv.recordings.defaults import UNMODELLED_TIME
from jawenv.recordings.dividing import divided
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.online import OnlineFilter
from jawenv.recordings.plausibility import Finding, findings
from jawenv.recordings.record import Record

# What honest recordings stay below (python -m research.anyone people).
LARGEST_MISFIT = 1.0
MOST_REFUSED = 0.05
MOST_LEFT_OUT = 0.1
LEAST_S = 0.5
HOTTEST = 10.0
"""Times that information was divided by until parts agreed, beyond which no number is believed."""
EVERY = 5


@dataclass(frozen=True, eq=False)
class Identification:
    """The identification of a recording."""

    estimate: Estimate  # the belief over time
    rows: int  # at which something of the encoders was read
    learnt_s: float  # time of the rows from which something was learnt: at the teeth nothing is
    refused: int  # rows whose readings the filter's gate did not learn from
    numbers: int  # read by encoders and load cell
    left_out: int  # numbers out of range, or repeated
    misfit: float  # the filter's alarm; it rings above 1
    findings: tuple[Finding, ...]  # what the recording shows before the filter
    rival: str = ""  # what explains the readings as well and is not believed, or why this is not known, in words
    temperature: float = 1.0  # what the information was divided by until parts of the recording agreed

    @property
    def doubts(self) -> list[str]:
        """Why the estimates are not to be believed, and what to look at; empty where they are."""
        doubts = [
            f"{finding.columns}: {finding.value}; allowed: {finding.allowed}"
            for finding in self.findings
            if not finding.plausible
        ]
        if not doubts and self.learnt_s < LEAST_S:
            doubts.append(f"rows that teach: {self.learnt_s:.2g} s; allowed: {LEAST_S:g} s or more, off the teeth")
        if not self.misfit <= LARGEST_MISFIT:
            doubts.append(f"the readings do not fit the model: misfit {self.misfit:.3g}; allowed: {LARGEST_MISFIT:g}")
        if not self.temperature <= HOTTEST:
            parts = f"parts of the recording disagree by {self.temperature:.3g} times what chance makes"
            doubts.append(f"{parts}; allowed: {HOTTEST:g}")
        if self.rival:
            doubts.append(self.rival)
        for what, share, most in (
            ("rows refused by the filter's gate", self.refused / max(self.rows, 1), MOST_REFUSED),
            ("numbers left out", self.left_out / max(self.numbers, 1), MOST_LEFT_OUT),
        ):
            if share > most:
                doubts.append(f"{what}: {100.0 * share:.3g} %; allowed: {100.0 * most:g} %")
        return doubts

    @property
    def believable(self) -> bool:
        """Whether nothing speaks against the estimates."""
        return not self.doubts


def identified(record: Record) -> Identification:
    """Run the filter over a recording; ticks longer than 10 ms are divided (``dividing.divided``)."""
    short = divided(record, max(1, round(record.dt / UNMODELLED_TIME)))
    online = OnlineFilter.of_record(short, every=EVERY)
    times, means, covs, left_out = [], [], [], 0
    for tick, measured in enumerate(short.measured):
        belief = online.update(measured, short.samples[tick - 1] if tick else None)
        left_out += belief.left_out
        if tick % EVERY == 0:
            times.append(short.time[tick])
            means.append(belief.log_mean)
            covs.append(belief.log_cov)
    encoders, cell = np.isfinite(short.measured), np.isfinite(short.samples).all(axis=1)
    missing = np.sum(~encoders) + np.sum(~cell)
    return Identification(
        estimate=Estimate("tension filter", np.array(times), np.array(means), np.array(covs)),
        rows=int(encoders.any(axis=1).sum()),
        learnt_s=belief.learnt * short.dt,
        refused=belief.gated,
        numbers=int(encoders.sum() + cell.sum()),
        left_out=int(left_out - missing),
        misfit=belief.misfit,
        findings=tuple(findings(record)),
    )
