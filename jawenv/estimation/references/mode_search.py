"""Early readings, filtered again about what they have taught.

The motion is filtered at the present guess of the muscles, and the first guess is the prior's mean. What readings say
about tensions is linear, so that little of it depends on the guess (``tension_filter``). The motion in between does:
where encoders are slow, or leave the pose open as one point does, a wrong guess moves it by degrees, and what has been
gathered along that motion is wrong for good. At the ends of *windows* of 20, 40 and 80 readings of the encoders
everything read so far is therefore filtered once more from the first tick on, as if the muscles were as believed now.

Where the whole pose is read in every tick, one such replay in each window is enough, and 80 readings are the last
window. Where it is left open, by one point or by encoders that are slower than the ticks, the belief may settle on
more than one motion, as least squares have more than one minimum. Windows then grow by a quarter each, to the end of
the record; in each, several starts are followed until they stay, and the belief is the sum of the normals found
(``mixture``), weighted by their posterior densities (Laplace's approximation, with the motion integrated out).
"""

from __future__ import annotations

from math import log

import numpy as np

from jawenv.compiled import njit, njit_within
from jawenv.estimation.model.encoders import N_MEASUREMENTS
from jawenv.estimation.model.step import N_NOISE, N_SAMPLES
from jawenv.estimation.online.posterior import factor_positive
from jawenv.estimation.online.state import forget_readings, guess
from jawenv.estimation.online.tick import begin_motion, learn, take_readings
from jawenv.estimation.online.time_update import tension_fields
from jawenv.estimation.references.mixture import (
    SAME,
    densest_mode,
    distance,
    forget_modes,
    keep_mode,
    nearest_mode,
    set_others,
    sum_up,
)
from jawenv.mechanics.dynamics import N_WRENCH

FIRST_WINDOW, LAST_WINDOW = 20, 80  # readings
# Of windows where the pose is left open. Twice as long ones are as good where they end, and go astray in between.
GROWTH = 1.25
KEPT = 3  # modes of the last window, beside the densest, that the search starts from again
N_STARTS = 4 + KEPT  # of the search for beliefs that fit, at most; a smoother has one more
PASSES = 16  # at most, over a window from one start, until one moves no parameter by
SMALL_STEP = 0.1  # sds or more
SMALLEST_SHARE = 0.1  # of a pass's step; what shorter ones lead to is where the search is
DENSER = 2.0  # nats by which the density has grown if a longer step to come does not matter
APART = 0.5  # prior sds of log F_o by which two of the starts have one half of the muscles stronger, the other weaker
SEARCHES = 5  # for the belief at the end of a window: each of a few rounds


def online_scratch_dtype(n_muscles: int, n_lines: int, n_states: int, n_nodes: int) -> np.dtype[np.void]:
    """Dtype of the online filter's working memory."""
    parameters = 2 * n_muscles
    fields = [
        *tension_fields(n_muscles, n_lines, n_states, n_nodes),
        ("usable", "f8", (N_SAMPLES, N_WRENCH)),  # of the load cell's samples, what is believed
        ("known", "f8", N_NOISE),  # variance of the wrench not known
        ("used", "u1", N_MEASUREMENTS),
        ("starts", "f8", (N_STARTS, parameters)),
        ("about", "f8", (parameters,)),
        ("origin", "f8", (parameters,)),
        ("goal", "f8", (parameters,)),
        ("tried", "f8", (parameters,)),
    ]
    return np.dtype(fields, align=True)


@njit
def ends_window(belief, settings, scratch):
    """Whether readings are to be filtered again after this tick."""
    if not scratch.used.any():
        return False
    if settings.pose_open:
        return belief.read >= max(FIRST_WINDOW, GROWTH * belief.window)
    window = FIRST_WINDOW
    while window < belief.read:
        window *= 2
    return belief.read == window and window <= LAST_WINDOW


@njit_within
def renew(jaw, device, belief, rows, tick, settings, scratch):
    """At the end of a window: filter ``rows`` 0 to ``tick`` again about the belief, or search for all that fit.

    Args:
        jaw: The filter's model.
        device: Record of dtype ``DEVICE``.
        belief: What the filter carries.
        rows: (> tick) records of dtype ``tick_dtype``.
        tick: The last.
        settings: See ``tick.filter_settings_dtype``.
        scratch: Working memory.
    """
    learn(belief, settings, scratch)
    if not settings.pose_open:
        replay(jaw, device, belief, rows, tick, settings, scratch)
        return
    number = set_starts(belief, settings, scratch.starts)
    search(jaw, device, belief, rows, tick, settings, scratch, scratch.starts[:number], PASSES, SMALL_STEP)
    belief.window = belief.read


@njit
def set_starts(belief, settings, starts):
    """Where to search: what the last search found, the prior's mean, and the belief's bent.

    In this order: the mode, up to ``KEPT`` of the others, the prior's mean, and the mode with one half of the muscles
    stronger and the other weaker, either way. Returns how many rows of ``starts`` (>= N_STARTS, p) are set.
    """
    size, number = starts.shape[1], 1
    starts[0] = belief.mode_mean
    densest = densest_mode(belief)
    for k in range(belief.n_modes):
        if k != densest and number <= KEPT:
            starts[number] = belief.modes_mean[k]
            number += 1
    starts[number] = settings.prior_mean
    for i in range(size):
        apart = 0.0
        if i % 2 == 0:
            apart = APART * settings.prior_sd[i] * (1.0 if i < size // 2 else -1.0)
        starts[number + 1, i] = belief.mode_mean[i] + apart
        starts[number + 2, i] = belief.mode_mean[i] - apart
    return number + 3


@njit_within
def search(jaw, device, belief, rows, tick, settings, scratch, starts, passes, small_step):
    """The modes of rows 0 to ``tick`` found from ``starts`` (S, p): the densest to go on with, the others beside it."""
    forget_modes(belief)
    at = -1
    for s in range(starts.shape[0]):
        density, new = settle(jaw, device, belief, rows, tick, settings, scratch, starts[s], passes, small_step)
        at = keep_mode(belief, density, scratch.about) if new else -1
    best = densest_mode(belief)
    if best < 0:
        filter_at(jaw, device, belief, rows, tick, settings, scratch, settings.prior_mean)
        return
    if at != best:
        filter_at(jaw, device, belief, rows, tick, settings, scratch, belief.modes_about[best])
    set_others(belief)
    sum_up(belief)


@njit_within
def settle(jaw, device, belief, rows, tick, settings, scratch, start, passes, small_step):
    """Follow a start until the belief stays where the readings were filtered at, ``about``.

    Each pass takes the whole step of the linear problem that the last one found. Where that leads to a longer step, it
    went too far, and half of it is tried: undamped, some beliefs jump to and fro between guesses of which none fits.

    Returns:
        The logarithm of the density there, and False where it comes to a mode that is kept, or is no number.
    """
    origin, goal, share = scratch.origin, scratch.goal, 1.0
    origin[:] = start
    reached = filter_at(jaw, device, belief, rows, tick, settings, scratch, start)
    goal[:] = belief.mode_mean
    density, left = reached, distance(belief, origin)
    for _ in range(passes - 1):
        if not reached > -np.inf or left < small_step or share < SMALLEST_SHARE:
            break
        if nearest_mode(belief)[1] < SAME:
            return reached, False
        for i in range(origin.shape[0]):
            scratch.tried[i] = origin[i] + share * (goal[i] - origin[i])
        reached = filter_at(jaw, device, belief, rows, tick, settings, scratch, scratch.tried)
        ahead = distance(belief, scratch.tried)
        if ahead < left or reached > density + DENSER:
            origin[:] = scratch.tried
            goal[:] = belief.mode_mean
            density, left, share = reached, ahead, min(1.0, 2.0 * share)
        else:
            share *= 0.5
    return reached, reached > -np.inf


@njit_within
def filter_at(jaw, device, belief, rows, tick, settings, scratch, parameters):
    """``replay`` as if the muscles were ``parameters`` (p), of which nothing is known but the prior."""
    scratch.about[:] = parameters
    guess(settings.basis, belief, parameters, settings.prior_sd)
    return replay(jaw, device, belief, rows, tick, settings, scratch)


@njit_within
def replay(jaw, device, belief, rows, tick, settings, scratch):
    """Filter rows 0 to ``tick`` from the first on about the belief's mean, and learn at the end alone.

    Returns the logarithm of the posterior's density there, but for a constant; NaN where the filter has lost the jaw.
    """
    begin_motion(belief, rows[0].believed, settings.start_sd)
    forget_readings(belief)
    for k in range(tick + 1):
        take_readings(jaw, device, belief, rows[k].measured, rows[k].samples, k, settings, scratch)
    density = -belief.misfit
    gain = belief.score.shape[0] - 1
    if settings.gain_variance > 0.0:
        score, known = belief.score[gain], belief.information[gain, gain]
        density += 0.5 * score * score / (known + 1.0 / settings.gain_variance)
        density -= 0.5 * log(1.0 + known * settings.gain_variance)
    for i in range(settings.prior_sd.shape[0]):
        away = (belief.mode_mean[i] - settings.prior_mean[i]) / settings.prior_sd[i]
        density -= 0.5 * away * away
    for _ in range(SEARCHES):
        learn(belief, settings, scratch)
    return density + 0.5 * log_det(belief.mode_cov, scratch.posterior.precision)


@njit
def log_det(matrix, factor):
    """Of a symmetric positive definite matrix; NaN if it is not one. ``factor`` is overwritten."""
    factor[:, :] = matrix
    if not factor_positive(factor):
        return np.nan
    value = 0.0
    for i in range(factor.shape[0]):
        value += 2.0 * log(factor[i, i])
    return value
