"""Precision of the estimates, and their distance from the truth."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from jawenv.base.errors import InputError

Array = npt.NDArray[np.float64]

# Half-width of a two-sided 95 % interval of a Gaussian, in standard deviations.
Z_95 = 1.959963984540054


def worst_sd(sd: Array) -> Array:
    """Largest standard deviation over the parameters.

    Args:
        sd: (..., P) standard deviations of the natural logs, so 0.05 is 5 %.

    Returns:
        (...).
    """
    worst: Array = np.max(sd, axis=-1)
    return worst


def time_to(sd: Array, time: Array, threshold: float, counts: npt.NDArray[np.bool_] | None = None) -> Array:
    """First time at which no parameter's standard deviation is above a threshold, and the belief counts.

    Args:
        sd: (N, T, P) standard deviations over time.
        time: (T,) in s.
        threshold: of the worst standard deviation, > 0 (0.1 is 10 %).
        counts: (N, T) at which times a belief counts, as `Recording.counts`; at all by default.

    Returns:
        (N,) in s; infinite where it never happened.
    """
    if not threshold > 0.0:
        raise InputError(f"threshold is {threshold}; allowed: a value above 0")
    reached = worst_sd(sd) <= threshold
    if counts is not None:
        reached = reached & counts
    first = np.argmax(reached, axis=-1)
    return np.where(reached.any(axis=-1), time[first], np.inf)


def for_good(holds: npt.NDArray[np.bool_], time: Array, counts: npt.NDArray[np.bool_] | None = None) -> Array:
    """First time at which a belief counts and from which on something holds to the end.

    Args:
        holds: (N, T) whether it does.
        time: (T,) in s.
        counts: (N, T) at which times a belief counts, as `Recording.counts`; at all by default.

    Returns:
        (N,) in s; infinite where it does not hold at the end.
    """
    reached = np.logical_and.accumulate(holds[:, ::-1], axis=1)[:, ::-1]
    if counts is not None:
        reached = reached & counts
    return np.where(reached.any(axis=1), time[np.argmax(reached, axis=1)], np.inf)


def identified(mean: Array, sd: Array, truth: Array, sd_limit: float = 0.10) -> npt.NDArray[np.bool_]:
    """Mask of the parameters that are known: a small standard deviation *and* the truth inside the 95 % interval.

    Args:
        mean: (..., P) of the natural logs.
        sd: (..., P).
        truth: (..., P).
        sd_limit: largest standard deviation that counts as known.

    Returns:
        (..., P) bool.
    """
    precise: npt.NDArray[np.bool_] = (sd <= sd_limit) & (np.abs(mean - truth) <= Z_95 * sd)
    return precise


def rmse(error: Array, axis: int | tuple[int, ...] = -1) -> Array:
    """Root of the mean squared error of the natural logs.

    Args:
        error: estimate minus truth, any shape.
        axis: over which to average.

    Returns:
        `error`'s shape without `axis`.
    """
    root: Array = np.sqrt(np.mean(np.square(error), axis=axis))
    return root


def rmse_over_bound(error: Array, bound_sd: Array) -> Array:
    """Error of every parameter over patients, as a multiple of the lowest that any estimator could reach.

    The posterior Cramer-Rao bound limits the mean square, so both are averaged as squares before the ratio is
    taken.

    Args:
        error: (N, P) estimate minus truth of N patients.
        bound_sd: (N, P) bound of the standard deviation; NaN where it was not computed.

    Returns:
        (P,); 1 means that the estimator wastes nothing.
    """
    ratio: Array = rmse(error, axis=0) / rmse(bound_sd, axis=0)
    return ratio
