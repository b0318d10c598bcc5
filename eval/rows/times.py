"""Time until the truth is found: the score of a patient, and its row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import pandas as pd

from eval.kept.cells import Rows
from eval.kept.entries import Entry
from eval.rows import outcomes
from eval.rows.outcomes import outcomes_of
from jawenv.base.errors import InputError
from jawenv.metrics import time_to
from jawenv.metrics.precision import for_good
from jawenv.playing.recording import Recording

Array = npt.NDArray[np.float64]
LEVELS = (0.20, 0.10, 0.05, 0.02)
"""Relative errors with a column of times in every task."""
_OF_THE_EPISODE = ("seed", "worst_sd", "rmse", "nees", "discomfort_s", "violated")
_FOUND = tuple(f"within_{level:g}_s" for level in LEVELS)
COLUMNS = (*_OF_THE_EPISODE, *_FOUND, "claimed_s", "completed", "score_s")
"""Columns of every patient; see docs/studies.md."""


def _within_for_good(recording: Recording, within: float) -> Array:
    """First time from which on no estimate is further from the truth than a share of it, to the end of the episode.

    Args:
        recording: of N patients.
        within: largest relative error of every parameter, > 0 (0.05 is 5 %).

    Returns:
        (N,) in s; infinite where it never happens, and where the episode ends early: a hard limit was crossed, or the
        filter diverged.
    """
    if not within > 0.0:
        raise InputError(f"within is {within}; allowed: a share above 0")
    relative = recording.of_asked(np.abs(np.expm1(recording.belief_mean - recording.truth[:, None])))
    reached = for_good(relative.max(axis=-1) <= within, recording.time)
    return np.where(completed(recording), reached, np.inf)


def completed(recording: Recording) -> npt.NDArray[np.bool_]:
    """(N,) whether the episode reached its time limit, and crossed no hard limit of comfort."""
    crossed = (recording.violation & recording.valid).any(axis=1)
    return np.asarray(~(recording.terminated | crossed))


def restricted(time: Array, episode_s: float) -> Array:
    """Times (N,) in s, `never` counted as the length of the episode."""
    return np.minimum(time, episode_s)


@dataclass(frozen=True)
class Times(Rows):
    """The time at which the truth is found."""

    columns = COLUMNS
    made_by: ClassVar[tuple[ModuleType, ...]] = (outcomes,)
    within: float  # largest relative error that the task allows
    episode_s: float  # length of its episodes
    comfort_limit_s: float = np.inf  # discomfort of an episode above which nothing counts as found
    seeds: tuple[int, ...] = ()  # of patients who do not follow each other, whose numbers are their places here

    def play(self, entry: Entry, number: int, seed: int, progress: Callable[[int, int], None]) -> pd.DataFrame:
        """See `Rows`."""
        seeds = list(self.seeds[seed : seed + number] or range(seed, seed + number))
        return self.rows_of(entry.play(number, seeds, progress, track_bound=False)).assign(seed=seeds)

    def rows_of(self, recording: Recording) -> pd.DataFrame:
        """The rows of a recording."""
        rows = outcomes_of(recording, 0)
        comfortable = rows["discomfort_s"].to_numpy() <= self.comfort_limit_s

        def found(level: float) -> Array:
            return np.where(comfortable, _within_for_good(recording, level), np.inf)

        for level, column in zip(LEVELS, _FOUND, strict=True):
            rows[column] = found(level)
        claimed = time_to(recording.of_asked(recording.belief_sd), recording.time, self.within, recording.counts)
        rows["claimed_s"] = restricted(claimed, self.episode_s)
        rows["completed"] = completed(recording)
        rows["score_s"] = restricted(found(self.within), self.episode_s)
        return rows[list(COLUMNS)]
