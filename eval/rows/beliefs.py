"""Errors and sds of a filter's belief about each patient at some times."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scoringrules import es_ensemble

from eval.kept.cells import Rows
from eval.kept.entries import Entry
from eval.rows import nuisances
from eval.rows.nuisances import NuisanceBeliefs
from jawenv.base.errors import InputError
from jawenv.metrics import claimed_information, covered, nees, true_information
from jawenv.playing.recording import Recording
from jawenv.recordings.estimate import Estimate
from jawenv.references.extended_kalman import ExtendedKalman

Array = NDArray[np.float64]

JUDGED, ENDED, DIVERGED = "judged", "ended", "diverged"
SIGMAS = (1, 2, 3)
DRAWS = 2000  # of a belief, for its energy score: by chance off by 1 % of the sds
LATE = 1e-6  # s; by how much a kept time may miss the wanted one
TENSION = "tension"
"""The environment's own filter: its belief stands in the recording and is not computed again."""
THESIS_RATE = 0.01  # relative, per square root of a second: the constant noise of Young (2016)

OTHERS: Mapping[str, Callable[[int], ExtendedKalman]] = MappingProxyType(
    {
        "ekf-decaying": lambda every: ExtendedKalman("log", every=every),
        "ekf-constant": lambda every: ExtendedKalman("log", THESIS_RATE, math.inf, every),
        "ekf-none": lambda every: ExtendedKalman("log", 0.0, every=every),
        "ekf-linear": lambda every: ExtendedKalman("linear", THESIS_RATE, math.inf, every),
    }
)
"""Filters to calibrate by their names on the command line: made from the ticks between the kept beliefs."""


def filters_named(names: Sequence[str]) -> tuple[str, ...]:
    """The same names, each once."""
    allowed = (TENSION, *OTHERS)
    for name in names or ("",):
        if name not in allowed:
            raise InputError(f"filters is {name!r}; allowed: {', '.join(allowed)}")
    return tuple(dict.fromkeys(names))


@dataclass(frozen=True)
class Beliefs(Rows):
    """Belief of a filter, with its nuisances where it is the environment's own and has some."""

    columns = ("time_s", "seed", "outcome")
    made_by = (nuisances,)
    filter: str  # name, `TENSION` or one of `OTHERS`
    times: tuple[float, ...]  # s, growing, each a time of the control steps

    def play(self, entry: Entry, number: int, seed: int, progress: Callable[[int, int], None]) -> pd.DataFrame:
        """See `Rows`."""
        own = self.filter == TENSION
        heard = NuisanceBeliefs(self.times) if own and not entry.world.build_knowledge().exact else None
        recording = entry.play(number, seed, progress, on_step=heard, record=not own)
        rows = rows_of(recording, self.filter, self.times, seed)
        return rows if heard is None else heard.added_to(rows, seed)


def rows_of(recording: Recording, name: str, times: Sequence[float], seed: int) -> pd.DataFrame:
    """One row per patient and time.

    ``outcome`` is ``judged``; ``ended`` where the episode ended before that time, at a hard limit or because the
    environment's own filter had diverged; or ``diverged`` where the filter itself has no belief there: its mean is not
    finite or its covariance not positive definite. Figures are NaN outside of ``judged`` rows.

    Args:
        recording: of N worlds, with their records unless the filter is the environment's own.
        name: of the filter, `TENSION` or one of `OTHERS`.
        times: s, growing, each a time of the recording's control steps.
        seed: of the first patient.
    """
    rows = []
    for world in range(recording.num_worlds):
        ends = float(recording.time[recording.last[world]])
        reached = tuple(time for time in times if time <= ends + LATE)
        estimate = _estimate(recording, world, name, reached)
        # Its own divergence ends the episode one step after the last belief, without a hard limit crossed.
        own = name == TENSION and bool(recording.terminated[world])
        own = own and not recording.violation[world, recording.last[world]]
        for time in times:
            row: dict[str, object] = {"time_s": time, "seed": seed + world}
            if time not in reached:
                rows.append(row | {"outcome": DIVERGED if own else ENDED})
                continue
            assert estimate is not None, "there is an estimate of every world that reached a time"
            rows.append(row | _judge(recording, world, estimate, time))
    return pd.DataFrame(rows, columns=_columns_of(recording.parameter_names))


def _columns_of(parameters: Sequence[str]) -> list[str]:
    """Names of the columns for these parameters."""
    figures = ["nees", "energy", "claimed", "true", *(f"inside_{sigmas}" for sigmas in SIGMAS)]
    own = [f"{kind}/{name}" for kind in ("error", "sd", "bound_sd") for name in parameters]
    return ["time_s", "seed", "outcome", *figures, *own]


def _estimate(recording: Recording, world: int, name: str, times: tuple[float, ...]) -> Estimate | None:
    """A filter's belief of one world at least at these times; None where there are none."""
    if not times:
        return None
    if name == TENSION:
        return Estimate(name, recording.time, recording.belief_mean[world], recording.belief_cov[world])
    assert recording.records is not None, "the worlds were played with record=True"
    record = recording.records[world]
    every = round(float(recording.time[1]) / record.dt)
    return OTHERS[name](every).estimate(record)


def _judge(recording: Recording, world: int, estimate: Estimate, time: float) -> dict[str, object]:
    """The figures of one belief."""
    index, step = _index_of(estimate.time, time), _index_of(recording.time, time)
    mean, cov, truth = estimate.mean[index], estimate.cov[index], recording.truth[world]
    if not (np.isfinite(mean).all() and np.isfinite(cov).all()):
        return {"outcome": DIVERGED}
    try:
        claimed = claimed_information(cov, recording.prior_sd)
    except InputError:
        return {"outcome": DIVERGED}
    error, sd = mean - truth, np.sqrt(np.diagonal(cov))
    figures: dict[str, object] = {
        "outcome": JUDGED,
        "nees": float(nees(error, cov)),
        "energy": _energy_score(error, cov),
        "claimed": float(claimed),
        "true": float(true_information(truth, mean, cov, recording.prior_mean, recording.prior_sd)),
    }
    figures |= {f"inside_{sigmas}": float(covered(error, sd, sigmas).mean()) for sigmas in SIGMAS}
    for kind, values in (("error", error), ("sd", sd), ("bound_sd", recording.bound_sd[world, step])):
        figures |= {f"{kind}/{name}": float(values[i]) for i, name in enumerate(recording.parameter_names)}
    return figures


def _energy_score(error: Array, cov: Array) -> float:
    """Mean distance of a normal belief's draws from the truth less half of that between two of them."""
    draws = np.random.default_rng(0).multivariate_normal(error, cov, DRAWS, method="cholesky")
    return float(es_ensemble(np.zeros(len(error)), draws, estimator="akr", backend="numpy"))


def _index_of(times: Array, time: float) -> int:
    """Number of the kept time nearest to a time."""
    index = int(np.abs(times - time).argmin())
    if abs(float(times[index]) - time) > LATE:
        raise InputError(f"times is {time:g}; allowed: multiples of the control step, {float(times[1]):g} s")
    return index
