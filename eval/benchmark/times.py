"""When the truth is found: the score of a patient."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from jawenv.errors import InputError
from jawenv.playing.rollout import Recording

Array = npt.NDArray[np.float64]


def within_for_good(recording: Recording, within: float) -> Array:
    """First time from which on no estimate is further from the truth than a share of it, to the end of the episode.

    Args:
        recording: of N patients.
        within: largest relative error of every parameter, > 0 (0.05 is 5 %).

    Returns:
        (N,) in s; infinite where it never happens, and where the episode ends early: a hard limit was crossed, or the
        filter diverged.

    Raises:
        InputError: `within` is not positive.
    """
    if not within > 0.0:
        raise InputError(f"within: {within} given, allowed is a share above 0")
    relative = np.abs(np.expm1(recording.belief_mean - recording.truth[:, None]))
    outside = relative.max(axis=-1) > within
    steps = outside.shape[1]
    first = steps - np.argmax(outside[:, ::-1], axis=1)  # the step after the last one outside
    first = np.where(outside.any(axis=1), first, 0)
    reached = (first < steps) & completed(recording)
    return np.where(reached, recording.time[np.minimum(first, steps - 1)], np.inf)


def completed(recording: Recording) -> npt.NDArray[np.bool_]:
    """(N,) whose episode reached its time limit, and crossed no hard limit of comfort."""
    crossed = (recording.violation & recording.valid).any(axis=1)
    return np.asarray(~(recording.terminated | crossed))


def restricted(time: Array, episode_s: float) -> Array:
    """Times (N,) in s, those who never get there counted as the length of the episode."""
    return np.minimum(time, episode_s)
