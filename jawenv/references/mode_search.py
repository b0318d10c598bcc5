"""Posterior of the parameters from a whole record: motion integrated out, all linearised at the final estimate.

The online filter runs over the record at fixed parameters and updates its belief at the end, then again at the new
mean, until that converges. Where readings leave the pose open, as those of one point do, or encoders that are slower
than the ticks, more than one belief may stay, as least squares have more than one minimum: several starts are followed
(``ModeSearch``), and the estimate is the sum of the normals that they come to (``modes``).
"""

from __future__ import annotations

from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.filter.belief.state import begin_belief, begin_motion, forget_readings
from jawenv.filter.learn import learn
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.tick import take_readings
from jawenv.filter.updates.measurement_update import UpdateScratch
from jawenv.kernels.cholesky import log_det
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import decompose
from jawenv.kernels.records import record_zeros
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record
from jawenv.recordings.record_filter import Arguments, FilterRun
from jawenv.references.modes import (
    SAME,
    Modes,
    distance,
    keep_mode,
    mixture_moments,
    modes_dtype,
    nearest_mode,
)

Array = NDArray[np.float64]

FIRST_WINDOW, GROWTH = 20, 1.25  # readings; growth by 2 loses the mode of some patients
RESTARTS = 4  # modes of the last window that the search starts from again, the densest first
PASSES = 16  # at most, from one start, until one moves no parameter by
SMALL_STEP = 0.1  # sds or more
SMALLEST_SHARE = 0.1  # of a full step, below which the search ends
DENSITY_GAIN = 2.0  # nats; with at least this gain of the log-density a step is accepted even if the next is longer
# prior sds of log F_o by which two starts have one half of the muscles stronger and the other weaker
START_OFFSET = 0.5
STEPS = 20  # of the iteration, to the belief at the end of a pass


class ModeSearch:
    """All beliefs that a record leaves, where one motion is not all that fits.

    Windows of the record grow by a quarter each. In each, the search begins at the modes of the last one, at the
    prior's mean, and at the densest mode with one half of the muscles stronger and the other weaker, either way.

    Args:
        times: s, ends of the shortened records to estimate from; None for the whole record alone.
    """

    name = "mode search"

    def __init__(self, times: tuple[float, ...] | None = None) -> None:
        if times is not None and (len(times) == 0 or not (np.diff(times, prepend=0.0) > 0.0).all()):
            raise InputError(f"ModeSearch: times is {times!r}; allowed: growing numbers above 0")
        self.times = times

    def estimate(self, record: Record) -> Estimate:
        """The belief at ``times``, each from the record until then alone."""
        record.require_exact(self.name)
        run, size = FilterRun(record), len(record.prior.mean)
        ends = np.array([run.last] if self.times is None else np.round(np.array(self.times) / record.dt), dtype=int)
        if ends[-1] > run.last:
            raise InputError(f"ModeSearch: times end at {self.times}, the record at {record.time[-1]:g} s")
        modes = record_zeros(1, modes_dtype(size))[0]
        mean, cov = np.empty((len(ends), size)), np.empty((len(ends), size, size))
        row = 0
        for end in _windows(record, ends):
            self._search(run, int(end), modes)
            if end == ends[row]:
                mean[row], cov[row] = mixture_moments(modes)
                row += 1
        return Estimate(self.name, record.time[ends], mean, cov)

    def _search(self, run: FilterRun, end: int, modes: Any) -> None:
        """Replace the ``modes`` of the last window by those of the rows up to ``end``."""
        starts = _search_starts(modes, run.settings["prior_mean"], run.settings["prior_sd"])
        search(run.arguments, end, starts, PASSES, SMALL_STEP, modes)


def _search_starts(modes: NDArray[np.void], prior_mean: Array, prior_sd: Array) -> Array:
    """(S, p) where to begin: the densest modes, the prior's mean, and the densest mode bent either way."""
    number = int(modes["number"])
    order = np.argsort(-modes["density"][:number])[:RESTARTS]
    densest = modes["mean"][order[0]] if number else prior_mean
    half = len(prior_mean) // 2
    sign = np.where(np.arange(len(prior_mean)) < half, 1.0, -1.0)
    shift = np.where(np.arange(len(prior_mean)) % 2 == 0, START_OFFSET * sign * prior_sd, 0.0)
    return np.vstack([modes["mean"][order], prior_mean, densest + shift, densest - shift])


def _windows(record: Record, ends: NDArray[np.int_]) -> NDArray[np.int_]:
    """Rows at which a search is made: ends of growing windows, counted in readings, and ``ends``."""
    rows = np.flatnonzero(np.isfinite(record.measured).any(axis=1))
    sizes, size = [], float(FIRST_WINDOW)
    while size < len(rows):
        sizes.append(rows[int(size) - 1])
        size = max(size + 1.0, GROWTH * size)
    window_ends: NDArray[np.int_] = np.unique(np.concatenate([np.array(sizes, dtype=int), ends]))
    return np.asarray(window_ends[window_ends <= ends[-1]], dtype=np.int_)


def _leaves_pose_open(record: Record) -> bool:
    """Whether a tick measures fewer pose components than there are free coordinates: several motions may fit."""
    finite = np.isfinite(record.measured)
    pose_readings = finite.any(axis=1).mean() * finite[:, : N_MEASUREMENTS // 2].any(axis=0).sum()
    return bool(pose_readings < np.sum(record.start_sd[: len(record.start_sd) // 2] > 0.0))


def integrate_out(record: Record, start: Array, small_step: float = 0.01) -> tuple[Array, Array]:
    """Mean (p,) and covariance (p, p) of the natural-log parameters from a whole record.

    Args:
        record: the record.
        start: (p,) where to begin, besides where ``ModeSearch`` ends where the pose is left open.
        small_step: sds, of a pass that ends the search.
    """
    run = FilterRun(record)
    modes = record_zeros(1, modes_dtype(len(start)))[0]
    starts = np.array(start)[None]
    if _leaves_pose_open(record):
        starts = np.vstack([starts, ModeSearch().estimate(record).mean])
    search(run.arguments, run.last, starts, PASSES, small_step, modes)
    return mixture_moments(modes)


@njit
def search(run: Arguments, tick, starts, passes, small_step, modes: Modes):
    """Fill ``modes`` from rows 0 to ``tick`` by searches from ``starts`` (S, p); with the prior where all diverge."""
    belief, settings = run.belief, run.settings
    modes.number = 0
    parameters = np.empty(starts.shape[1])
    for s in range(starts.shape[0]):
        parameters[:] = starts[s]
        density, new = settle(run, tick, parameters, passes, small_step, modes)
        if new:
            keep_mode(modes, belief, density)
    if modes.number == 0:
        begin_belief(settings.basis, belief, settings.prior_mean, settings.prior_sd)
        keep_mode(modes, belief, 0.0)


@njit
def settle(run: Arguments, tick, parameters, passes, small_step, modes: Modes):
    """Iterate from ``parameters`` (p) until the belief's mean equals the linearisation point, which is overwritten.

    Each pass takes the full Gauss-Newton step of the last. If the next step is longer, the step is halved: without
    damping some searches oscillate.

    Returns:
        The logarithm of the density there, and False where it comes to a mode that is kept, or is no number.
    """
    belief, origin, share = run.belief, parameters.copy(), 1.0
    reached = _filter_at(run, tick, parameters)
    goal = belief.mean.copy()
    density, step_length = reached, distance(belief, origin)
    for _ in range(passes - 1):
        if not reached > -np.inf or step_length < small_step or share < SMALLEST_SHARE:
            break
        if nearest_mode(modes, belief)[1] < SAME:
            return reached, False
        parameters[:] = origin + share * (goal - origin)
        reached = _filter_at(run, tick, parameters)
        next_length = distance(belief, parameters)
        if next_length < step_length or reached > density + DENSITY_GAIN:
            origin[:] = parameters
            goal[:] = belief.mean
            density, step_length, share = reached, next_length, min(1.0, 2.0 * share)
        else:
            share *= 0.5
    return reached, reached > -np.inf


@njit
def _filter_at(run: Arguments, tick, parameters):
    """Filter rows 0 to ``tick``, linearised at ``parameters`` (p), and update the belief from the prior.

    Returns the logarithm of the posterior's density there, but for a constant; NaN where the filter diverges.
    """
    belief, rows, settings, scratch = run.belief, run.rows, run.settings, run.scratch
    begin_belief(settings.basis, belief, parameters, settings.prior_sd)
    begin_motion(belief, belief.began, settings.start_sd)
    forget_readings(belief)
    density = 0.0
    for k in range(tick + 1):
        take_readings(run.jaw, belief, rows[k].measured, rows[k].samples, k, settings, scratch)
        # Of what is learnt from, as the information is.
        if scratch.used.any() and belief.waits == 0 and belief.near == 0:
            density += log_likelihood(scratch.update)
    gain = belief.nominal.size
    if settings.gain_variance > 0.0:
        score, gain_information = belief.score[gain], belief.information[gain, gain]
        density += 0.5 * score * score / (gain_information + 1.0 / settings.gain_variance)
        density -= 0.5 * log(1.0 + gain_information * settings.gain_variance)
    for i in range(settings.prior_sd.shape[0]):
        deviation = (belief.mean[i] - settings.prior_mean[i]) / settings.prior_sd[i]
        density -= 0.5 * deviation * deviation
    for _ in range(STEPS):
        learn(belief, settings, scratch.belief)
    factor = scratch.belief.posterior.precision
    factor[:, :] = belief.cov
    return density + 0.5 * log_det(factor) if decompose(factor) else np.nan


@njit
def log_likelihood(update: UpdateScratch):
    """Log-likelihood of the last innovation, but for a constant; ``factor`` has the inverse of L's diagonal."""
    value = 0.0
    for i in range(N_MEASUREMENTS):
        value += log(update.factor[i, i]) - 0.5 * update.whitened_innovation[i] ** 2
    return value
