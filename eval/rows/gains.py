"""Information gain of every patient's record."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass, fields
from functools import cache

import pandas as pd

from eval.kept.cells import Rows
from eval.kept.entries import Entry
from jawenv.envs.configuration import Configuration
from jawenv.inference.information_gain import InformationGain, information_gain
from jawenv.inference.patient_law import PatientLaw

FIGURES = tuple(field.name for field in fields(InformationGain))
COLUMNS = ("seed", *FIGURES, "claimed", "ended")


@cache
def _law_of(world: Configuration) -> PatientLaw:
    """The prior, once for all parts of a process."""
    return PatientLaw.of(world.build_cohort(), env_id=world.env_id)


@dataclass(frozen=True)
class Gains(Rows):
    """Bounds on the information gain of each record."""

    columns = COLUMNS
    contrasts: int  # of each record, drawn by its patient's seed; 0 leaves the contrastive bounds out

    def play(self, entry: Entry, number: int, seed: int, progress: Callable[[int, int], None]) -> pd.DataFrame:
        """See `Rows`."""
        recording, law = entry.play(number, seed, progress, record=True), _law_of(entry.world)
        assert recording.records is not None, "the worlds were played with record=True"
        means, covs = recording.at_end(recording.belief_mean), recording.at_end(recording.belief_cov)
        claimed = recording.at_end(recording.information_claimed)
        rows: list[tuple[object, ...]] = []
        for i, record in enumerate(recording.records):
            gain = information_gain(record, law, means[i], covs[i], contrasts=self.contrasts, seed=seed + i)
            rows.append((seed + i, *astuple(gain), float(claimed[i]), bool(recording.terminated[i])))
        return pd.DataFrame(rows, columns=list(COLUMNS))
