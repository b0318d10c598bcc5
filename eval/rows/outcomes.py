"""Outcome of a patient's episode: metrics at its end, and precision over time.

A row has patient's ``seed``, every metric of `jawenv.metrics.Score` at the end of the episode, with `truth/`, `error/`,
`sd/` and `bound_sd/` of every parameter, `used/` (largest used fraction) and `beyond/..._s` (time beyond it) of every
soft comfort limit, `EARLY_METRICS` after `EARLY_S`, ``known_nees`` (NEES when all are first within `KNOWN`, at the end
where they never are), and in `over_time/...` a value for each of some times: `time_s`,
sd and bound of every parameter, NEES and information. All sd are of natural logs: 0.05 is 5 %.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from eval.kept.cells import Rows
from eval.kept.entries import Entry
from jawenv.metrics import (
    claimed_information,
    nees,
    rmse,
    score,
    true_information,
    whole_muscles_per_line,
    worst_sd,
)
from jawenv.metrics.precision import for_good
from jawenv.metrics.score import KNOWN
from jawenv.metrics.standing import standing
from jawenv.playing.recording import Recording

Array = npt.NDArray[np.float64]
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
OVER_TIME = "over_time/"
MOMENTS = 60
_MEANS = ("nees", "information_claimed", "information_true")
NEES_QUANTILES = {"nees_median": 0.5, "nees_p90": 0.9}


@dataclass(frozen=True)
class Outcomes(Rows):
    """Outcomes of episodes."""

    columns = ("seed", *PATIENT_METRICS)
    bound: bool = True  # whether the posterior Cramer-Rao bound is computed
    over_time: bool = True  # whether the columns with a value for each time are kept, some 13 kB a patient

    def play(self, entry: Entry, number: int, seed: int, progress: Callable[[int, int], None]) -> pd.DataFrame:
        """See `Rows`."""
        rows = outcomes_of(entry.play(number, seed, progress, track_bound=self.bound), seed)
        return rows if self.over_time else without_times(rows)


def outcomes_of(recording: Recording, seed: int) -> pd.DataFrame:
    """The rows of a recording.

    Args:
        recording: of all patients of one entry.
        seed: of the first patient.
    """
    judged = score(recording)
    columns: dict[str, Any] = {"seed": seed + np.arange(recording.num_worlds)}
    columns |= {name: getattr(judged, name) for name in PATIENT_METRICS}
    columns |= _early(recording)
    columns |= _use_of_limits(recording)
    columns |= {f"time_to_{target:g}_s": seconds for target, seconds in judged.time_to_s.items()}
    columns |= {"verdicts_s": verdicts_s(recording), "known_nees": _known_nees(recording, judged.time_to_s[KNOWN])}
    columns |= {f"inside_{sigmas}_sigma": share for sigmas, share in judged.inside.items()}
    kinds = {"truth": recording.truth, "error": judged.error, "sd": judged.sd, "bound_sd": judged.bound_sd}
    for kind, values in kinds.items():
        columns |= {f"{kind}/{name}": values[:, i] for i, name in enumerate(recording.parameter_names)}
    columns |= {f"{OVER_TIME}{quantity}": list(values) for quantity, values in _over_time(recording).items()}
    return pd.DataFrame(columns)


def verdicts_s(recording: Recording) -> Array:
    """First time (N,), s, from which on the data have a verdict on every muscle; NaN unless lines are whole muscles."""
    if whole_muscles_per_line(recording.parameter_names) != 1.0:
        return np.full(recording.num_worlds, np.nan)
    stands = standing(recording.belief_mean, recording.belief_cov, recording.prior_sd).all(axis=-1)
    return for_good(stands & recording.valid, recording.time, recording.counts)


def _known_nees(recording: Recording, known_s: Array) -> Array:
    """NEES (N,) when all parameters are first known."""
    at = np.arange(recording.num_worlds), np.minimum(np.searchsorted(recording.time, known_s), recording.last)
    return nees(recording.belief_mean[at] - recording.truth, recording.belief_cov[at])


def _use_of_limits(recording: Recording) -> dict[str, Array]:
    """(N,) of every comfort limit: the largest used fraction of the soft limit, and s beyond it."""
    used = np.where(recording.valid[..., None], recording.comfort, 0.0)
    step = np.diff(recording.time)[:, None]
    columns = {}
    for i, name in enumerate(recording.comfort_names):
        columns[f"used/{name}"] = used[..., i].max(axis=1)
        columns[f"beyond/{name}_s"] = ((used[:, 1:, i] > 1.0) @ step)[:, 0]
    return columns


def _early(recording: Recording) -> dict[str, Array]:
    """(N,) of each of `EARLY_METRICS`; NaN where all episodes are shorter."""
    if recording.time[-1] < EARLY_S - 1e-9:
        return {name: np.full(recording.num_worlds, np.nan) for name in EARLY_METRICS}
    early = int(np.argmin(np.abs(recording.time - EARLY_S)))
    mean, cov = recording.belief_mean[:, early], recording.belief_cov[:, early]
    error, priors = mean - recording.truth, (recording.prior_mean, recording.prior_sd)
    information = true_information(recording.truth, mean, cov, *priors)
    worst = worst_sd(recording.of_asked(recording.belief_sd[:, early]))
    return dict(zip(EARLY_METRICS, (worst, information, nees(error, cov), rmse(error)), strict=True))


def _over_time(recording: Recording) -> dict[str, Array]:
    """(N, T) of each quantity at `MOMENTS` times or fewer, closer to each other at the start, where most is learned."""
    last = len(recording.time) - 1
    picked = np.unique(np.round(np.linspace(0.0, 1.0, MOMENTS) ** 2 * last).astype(int))
    mean, cov = recording.belief_mean[:, picked], recording.belief_cov[:, picked]
    truth = recording.truth[:, None]
    sd, bound = recording.belief_sd[:, picked], recording.bound_sd[:, picked]
    quantities: dict[str, Array] = {"time_s": np.tile(recording.time[picked], (recording.num_worlds, 1))}
    for i, name in enumerate(recording.parameter_names):
        quantities |= {f"sd/{name}": sd[..., i], f"bound_sd/{name}": bound[..., i]}
    information = true_information(truth, mean, cov, recording.prior_mean, recording.prior_sd)
    means = (nees(mean - truth, cov), claimed_information(cov, recording.prior_sd), information)
    return quantities | dict(zip(_MEANS, means, strict=True))


def without_times(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows without the columns that hold a value for each time."""
    return rows[[column for column in rows if not str(column).startswith(OVER_TIME)]]


def curves(rows: pd.DataFrame) -> pd.DataFrame:
    """Quantiles and means over the patients of one entry, over time.

    Args:
        rows: of `outcomes_of`.

    Returns:
        One row per quantity and time: time_s, quantity, and over the patients `low` (10 %), `centre` (median) and
        `high` (90 %); `bound` is the median of the posterior Cramer-Rao bound. Quantities are `sd/<parameter>`,
        `worst_sd`, and with a centre alone the means `nees`, `information_claimed` and `information_true`, and
        `NEES_QUANTILES`.
    """
    names = [column.removeprefix("sd/") for column in map(str, rows) if column.startswith("sd/")]
    sd, bound = (np.stack([_stacked(rows, f"{kind}/{name}") for name in names], axis=-1) for kind in ("sd", "bound_sd"))
    tables = [_quantiles(f"sd/{name}", sd[..., i], bound[..., i]) for i, name in enumerate(names)]
    tables.append(_quantiles("worst_sd", worst_sd(sd), worst_sd(bound)))
    nothing = np.full(sd.shape[1], np.nan)
    centres = {quantity: _stacked(rows, quantity).mean(axis=0) for quantity in _MEANS}
    centres |= {name: np.quantile(_stacked(rows, "nees"), q, axis=0) for name, q in NEES_QUANTILES.items()}
    for quantity, centre in centres.items():
        columns = {"low": nothing, "centre": centre, "high": nothing, "bound": nothing}
        tables.append(pd.DataFrame({"quantity": quantity, **columns}))
    time = _stacked(rows, "time_s")[0]
    return pd.concat([table.assign(time_s=time) for table in tables], ignore_index=True)


def _stacked(rows: pd.DataFrame, quantity: str) -> Array:
    """(N, T)."""
    values: Sequence[Array] = rows[f"{OVER_TIME}{quantity}"].to_list()
    return np.stack(values)


def _quantiles(quantity: str, values: Array, bound: Array) -> pd.DataFrame:
    low, centre, high = np.quantile(values, [0.1, 0.5, 0.9], axis=0)
    return pd.DataFrame(
        {"quantity": quantity, "low": low, "centre": centre, "high": high, "bound": np.median(bound, axis=0)}
    )
