"""A comparison, in which every entry meets the same patients with the same noise, and its two tables.

`patients` has one row per entry and patient: entry, patient, and the columns of `eval.rows.outcomes`. `curves` has one
row per entry, quantity and time: entry, and those of `eval.rows.outcomes.curves`.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from rich.console import Console

from eval.kept.cells import Cell, play_cells
from eval.kept.entries import Entry, Settings
from eval.kept.parts import Run
from eval.kept.tables import made_with, read_table, write_table
from eval.rows.outcomes import PATIENT_METRICS, Outcomes, curves, without_times
from jawenv.base.errors import InputError
from jawenv.base.locks import alone
from jawenv.metrics import BLOCKED_B, STIFF_F_O_N, Diagnosis, diagnose, whole_muscles_per_line
from jawenv.playing.rollout import DEFAULT_ENV

if TYPE_CHECKING:
    from jawenv.rendering.scene import Scene

Array = npt.NDArray[np.float64]
PATIENTS, CURVES = "patients.parquet", "curves.parquet"


@dataclass(frozen=True)
class Results:
    """Tables of a comparison with their metadata."""

    patients: pd.DataFrame  # one row per patient and entry
    curves: pd.DataFrame  # one row per entry, time and quantity
    about: dict[str, Any]  # command, versions, seed, settings and entries
    motions: dict[str, list[Scene]] = field(default_factory=dict)
    """Motions of a patient under the entries, see `eval.comparison.motion`; may lack some, or all."""

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

    def diagnoses(self, entry: str) -> dict[str, tuple[float, Diagnosis]]:
        """Thresholds of `stiff` (pull) and `blocked` (stiffening), with the decisions on all muscles at the end."""
        truth, error, sd = (self.array(entry, name) for name in ("truth", "error", "sd"))
        forces_N = STIFF_F_O_N * whole_muscles_per_line(self.parameters)
        return {
            name: (limit, diagnose(truth[:, k::2], (truth + error)[:, k::2], sd[:, k::2], limit))
            for k, (name, limit) in enumerate((("stiff", forces_N), ("blocked", BLOCKED_B)))
        }


def compare(
    entries: Sequence[Entry],
    settings: Settings,
    output: Path | None = None,
    *,
    command: str = "",
    fresh: bool = False,
    console: Console | None = None,
) -> Results:
    """Play every entry on the same patients and noise; keep each as soon as it is finished.

    Args:
        entries: the contestants.
        settings: on whom and how.
        output: folder for `patients.parquet`, `curves.parquet` and what is kept, which is used again when nothing that
            decides it has changed; without a folder nothing is kept.
        command: how the user asked for it, for the results' metadata.
        fresh: compute every entry again.
        console: where progress is shown; nowhere by default.

    Returns:
        The tables of the comparison, as saved.
    """
    if not entries:
        raise InputError("nothing to compare: name a maneuver or a training run, or use --all-maneuvers")
    for entry in entries:
        if entry.env_id != settings.world.env_id:
            raise InputError(f"{entry.label} plays {entry.env_id}, but this comparison is in {settings.world.env_id}")
    with TemporaryDirectory() if output is None else nullcontext(output) as folder, alone(Path(folder)):
        # All patients of an entry together: threads share them out, and a yoked replay knows its patient by the place.
        seeds, outcomes = settings.seeds, Outcomes()
        cells = [
            Cell({"entry": entry.label}, partial(replace, entry), seeds, outcomes, len(seeds)) for entry in entries
        ]
        rows = play_cells(cells, Path(folder), Run(fresh, 1, console=console))
        metadata = made_with(command, settings=settings.to_mapping(), entries=[entry.about() for entry in entries])
        study = Results.of_rows(rows, metadata)
        if output is not None:
            save(study, output)
    return study


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
    """
    remedy = "repeat the comparison: what is finished is kept"
    patients, metadata = read_table(folder / PATIENTS, ("entry", "patient", *PATIENT_METRICS), remedy)
    of_times, _ = read_table(folder / CURVES, ("entry", "time_s", "quantity", "centre", "bound"), remedy)
    return Results(patients, of_times, metadata)
