"""The two tables of a study, and how the first patient was moved.

`patients` has one row per patient and entry: entry, patient, seed, and every metric of `jawenv.metrics.Score` at
the end of the episode, with `truth/`, `error/`, `sd/` and `bound_sd/` of every parameter, `used/` (largest used
fraction) and `beyond/..._s` (time beyond it) of every soft comfort limit, and `EARLY_METRICS` after `EARLY_S`.
`curves` has one row per entry, time and quantity: entry, time_s, quantity, and over the patients `low` (10 %),
`centre` (median) and `high` (90 %); `bound` is the median of the posterior Cramer-Rao bound. Quantities are
`sd/<parameter>`, `worst_sd`, and as means over the patients (no low or high) `nees`, `information_claimed` and
`information_true`. All sd are of natural logs: 0.05 is 5 %.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from eval.comparison import motion
from eval.kept.tables import read_table, write_table
from jawenv.metrics import claimed_information, nees, rmse, score, true_information, worst_sd
from jawenv.playing.recording import Recording
from jawenv.playing.rollout import DEFAULT_ENV

Array = npt.NDArray[np.float64]
_CURVE_INTERVAL_S = 0.1
EARLY_S = 10.0
"""When `EARLY_METRICS` are kept besides those at the end; in shorter episodes they are NaN."""
EARLY_METRICS = ("early_worst_sd", "early_information_true", "early_nees", "early_rmse")

PATIENT_METRICS = (
    "worst_sd",
    "worst_bound_sd",
    "information_claimed",
    "information_true",
    "information_bound",
    "honesty_gap",
    "nees",
    "nees_prior",
    "rmse",
    "identified",
    "discomfort_s",
    "largest_fraction",
    "violated",
    "misfit",
    "governor",
    "duration_s",
)


@dataclass(frozen=True)
class Results:
    """Tables of one entry, or of a whole study, and what they were made with.

    Attributes:
        patients: one row per patient and entry.
        curves: one row per entry, time and quantity.
        about: command, versions, seed, settings and entries.
        motions: how entries move the first patient, see `eval.comparison.motion`; may lack some, or all.
    """

    patients: pd.DataFrame
    curves: pd.DataFrame
    about: dict[str, Any]
    motions: dict[str, Any] = field(default_factory=dict)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters, in their order."""
        return tuple(name.removeprefix("sd/") for name in map(str, self.patients) if name.startswith("sd/"))

    @property
    def env(self) -> str:
        """Id of the environment that the entries were played in; tables of older studies do not say."""
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


def from_recording(recording: Recording, entry: str, seed: int, about: dict[str, Any]) -> Results:
    """Reduce a recording to its rows in both tables.

    Args:
        recording: of all patients of one entry.
        entry: its label.
        seed: of the first patient.
        about: what the results were made with.
    """
    judged = score(recording)
    number = recording.num_worlds
    columns: dict[str, Any] = {
        "entry": [entry] * number,
        "patient": np.arange(number),
        "seed": seed + np.arange(number),
    }
    columns |= {name: getattr(judged, name) for name in PATIENT_METRICS}
    columns |= _early(recording)
    columns |= _use_of_limits(recording)
    columns |= {f"time_to_{target:g}_s": seconds for target, seconds in judged.time_to_s.items()}
    columns |= {f"inside_{sigmas}_sigma": share for sigmas, share in judged.inside.items()}
    for prefix, values in (
        ("truth", recording.truth),
        ("error", judged.error),
        ("sd", judged.sd),
        ("bound_sd", judged.bound_sd),
    ):
        columns |= {f"{prefix}/{name}": values[:, i] for i, name in enumerate(recording.parameter_names)}
    return Results(pd.DataFrame(columns), _curves(recording, entry), about)


def _use_of_limits(recording: Recording) -> dict[str, Array]:
    """(N,) of every comfort limit: the largest used fraction of the soft limit, and s beyond it."""
    used = np.where(recording.valid[..., None], recording.comfort, 0.0)
    step = np.diff(recording.time)[:, None]
    found = {}
    for i, name in enumerate(recording.comfort_names):
        found[f"used/{name}"] = used[..., i].max(axis=1)
        found[f"beyond/{name}_s"] = ((used[:, 1:, i] > 1.0) @ step)[:, 0]
    return found


def _early(recording: Recording) -> dict[str, Array]:
    """(N,) of each of `EARLY_METRICS`; NaN where all episodes are shorter."""
    if recording.time[-1] < EARLY_S - 1e-9:
        return {name: np.full(recording.num_worlds, np.nan) for name in EARLY_METRICS}
    early = int(np.argmin(np.abs(recording.time - EARLY_S)))
    mean, cov = recording.belief_mean[:, early], recording.belief_cov[:, early]
    error, priors = mean - recording.truth, (recording.prior_mean, recording.prior_sd)
    information = true_information(recording.truth, mean, cov, *priors)
    worst = worst_sd(recording.belief_sd[:, early])
    return dict(zip(EARLY_METRICS, (worst, information, nees(error, cov), rmse(error)), strict=True))


def _curves(recording: Recording, entry: str) -> pd.DataFrame:
    """Quantiles and means over the patients at every tenth of a second."""
    step = float(recording.time[1] - recording.time[0])
    picked = np.arange(0, len(recording.time), max(1, round(_CURVE_INTERVAL_S / step)))
    if picked[-1] != len(recording.time) - 1:
        picked = np.append(picked, len(recording.time) - 1)
    time, cov = recording.time[picked], recording.belief_cov[:, picked]
    mean, truth = recording.belief_mean[:, picked], recording.truth[:, None]
    sd, bound = recording.belief_sd[:, picked], recording.bound_sd[:, picked]
    names = recording.parameter_names
    rows = [_quantiles(f"sd/{name}", sd[..., i], bound[..., i]) for i, name in enumerate(names)]
    rows.append(_quantiles("worst_sd", worst_sd(sd), worst_sd(bound)))
    means = {
        "nees": nees(mean - truth, cov),
        "information_claimed": claimed_information(cov, recording.prior_sd),
        "information_true": true_information(truth, mean, cov, recording.prior_mean, recording.prior_sd),
    }
    nothing = np.full(len(time), np.nan)
    for quantity, values in means.items():
        column = {"low": nothing, "centre": values.mean(axis=0), "high": nothing, "bound": nothing}
        rows.append(pd.DataFrame({"quantity": quantity, **column}))
    for frame in rows:
        frame.insert(0, "time_s", time)
    table = pd.concat(rows, ignore_index=True)
    table.insert(0, "entry", entry)
    return table


def _quantiles(quantity: str, values: Array, bound: Array) -> pd.DataFrame:
    low, centre, high = np.quantile(values, [0.1, 0.5, 0.9], axis=0)
    return pd.DataFrame(
        {"quantity": quantity, "low": low, "centre": centre, "high": high, "bound": np.median(bound, axis=0)}
    )


def join(parts: list[Results], about: dict[str, Any]) -> Results:
    """One study out of the results of its entries."""
    patients = pd.concat([part.patients for part in parts], ignore_index=True)
    curves = pd.concat([part.curves for part in parts], ignore_index=True)
    motions = {label: motion for part in parts for label, motion in part.motions.items()}
    return Results(patients, curves, about, motions)


def save(results: Results, folder: Path, stem: str = "") -> None:
    """Write `<stem>motions.json`, `<stem>curves.parquet` and `<stem>patients.parquet`, each whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    # The patients' table last: whoever finds it finds the others as well.
    motion.save(results.motions, folder / f"{stem}motions.json")
    write_table(results.curves, folder / f"{stem}curves.parquet", results.about)
    write_table(results.patients, folder / f"{stem}patients.parquet", results.about)


def load(folder: Path, stem: str = "") -> Results:
    """Read what `save` has written.

    Args:
        folder: of the study, or of its entries.
        stem: of an entry's files; empty for the whole study.

    Raises:
        InputError: a file is missing, damaged, or not a table of this program.
    """
    remedy = "delete it, or use --fresh" if stem else "repeat the comparison: entries that are finished are kept"
    wanted: tuple[str, ...] = ("entry", "patient", *PATIENT_METRICS)
    patients, about = read_table(folder / f"{stem}patients.parquet", wanted, remedy)
    wanted = ("entry", "time_s", "quantity", "centre", "bound")
    curves, _ = read_table(folder / f"{stem}curves.parquet", wanted, remedy)
    return Results(patients, curves, about, motion.load(folder / f"{stem}motions.json"))
