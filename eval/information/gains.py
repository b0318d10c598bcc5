"""What the record of every patient has told."""

from __future__ import annotations

from dataclasses import astuple, fields
from functools import cache

import pandas as pd

from jawenv.envs.configuration import Configuration
from jawenv.inference.information_gain import InformationGain, information_gain
from jawenv.inference.patient_law import PatientLaw
from jawenv.playing.recording import Recording

FIGURES = tuple(each.name for each in fields(InformationGain))
COLUMNS = ("seed", *FIGURES, "claimed", "ended")


@cache
def law_of(world: Configuration) -> PatientLaw:
    """The prior, once for all parts of a process."""
    return PatientLaw.of(world.build_cohort(), env_id=world.env_id)


def rows_of(recording: Recording, law: PatientLaw, seed: int, contrasts: int) -> pd.DataFrame:
    """One row per patient, with `COLUMNS`.

    Args:
        recording: of all patients, with their records.
        law: from which they were drawn.
        seed: of the first one, and of its contrasts.
        contrasts: of each record.
    """
    assert recording.records is not None, "the worlds were played with record=True"
    means, covs = recording.at_end(recording.belief_mean), recording.at_end(recording.belief_cov)
    claimed = recording.at_end(recording.information_claimed)
    rows: list[tuple[object, ...]] = []
    for i, record in enumerate(recording.records):
        gain = information_gain(record, law, means[i], covs[i], contrasts=contrasts, seed=seed + i)
        rows.append((seed + i, *astuple(gain), float(claimed[i]), bool(recording.terminated[i])))
    return pd.DataFrame(rows, columns=list(COLUMNS))
