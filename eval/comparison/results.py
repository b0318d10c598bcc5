"""The two tables of a comparison.

`patients` has one row per entry and patient: entry, patient, and the columns of `eval.rows.outcomes`. `curves` has one
row per entry, quantity and time: entry, and those of `eval.rows.outcomes.curves`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from eval.kept.tables import read_table, write_table
from eval.rows.outcomes import PATIENT_METRICS, curves, without_times
from jawenv.playing.rollout import DEFAULT_ENV

Array = npt.NDArray[np.float64]
PATIENTS, CURVES = "patients.parquet", "curves.parquet"


@dataclass(frozen=True)
class Results:
    """Tables of a comparison with their metadata.

    Attributes:
        patients: one row per patient and entry.
        curves: one row per entry, time and quantity.
        about: command, versions, seed, settings and entries.
        motions: how entries move a patient, see `eval.comparison.motion`; may lack some, or all.
    """

    patients: pd.DataFrame
    curves: pd.DataFrame
    about: dict[str, Any]
    motions: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of_rows(cls, rows: pd.DataFrame, metadata: dict[str, Any]) -> Results:
        """Both tables of the rows of `eval.rows.outcomes.Outcomes`, which have a column ``entry`` besides."""
        patients = without_times(rows)
        patients.insert(1, "patient", patients.groupby("entry", sort=False).cumcount())
        of_entries = [curves(group).assign(entry=entry) for entry, group in rows.groupby("entry", sort=False)]
        return cls(patients, pd.concat(of_entries, ignore_index=True), metadata)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters, in their order."""
        return tuple(name.removeprefix("sd/") for name in map(str, self.patients) if name.startswith("sd/"))

    @property
    def env(self) -> str:
        """Id of the environment that the entries were played in."""
        env: str = self.about.get("settings", {}).get("env", DEFAULT_ENV)
        return env

    @property
    def entries(self) -> tuple[str, ...]:
        """Labels, in the order in which they were played."""
        return tuple(dict.fromkeys(self.patients["entry"]))

    def of(self, entry: str) -> pd.DataFrame:
        """The patients' rows of one entry, in the order of the patients."""
        return self.patients[self.patients["entry"] == entry].sort_values("patient")

    def array(self, entry: str, prefix: str) -> Array:
        """(N, P) of one entry: `sd`, `error`, `bound_sd` or `truth` of every parameter."""
        return self.of(entry)[[f"{prefix}/{name}" for name in self.parameters]].to_numpy(dtype=np.float64)


def save(results: Results, folder: Path) -> None:
    """Write both tables, each whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    # The patients' table last: whoever finds it finds the curves as well.
    write_table(results.curves, folder / CURVES, results.about)
    write_table(results.patients, folder / PATIENTS, results.about)


def load(folder: Path) -> Results:
    """Read a folder of `save`.

    Args:
        folder: of the comparison.

    Raises:
        InputError: a file is missing, damaged, or not a table of this program.
    """
    remedy = "repeat the comparison: what is finished is kept"
    patients, metadata = read_table(folder / PATIENTS, ("entry", "patient", *PATIENT_METRICS), remedy)
    of_times, _ = read_table(folder / CURVES, ("entry", "time_s", "quantity", "centre", "bound"), remedy)
    return Results(patients, of_times, metadata)
