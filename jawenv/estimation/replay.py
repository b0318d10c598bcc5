"""Early readings, filtered again about what they have taught.

The motion is filtered at the present guess of the muscles, and the first guess is the prior's mean. What readings say
about tensions is linear, so that little of it depends on the guess (``tension_filter``). The motion in between does:
where encoders are slow, or leave the pose open as one point does, a wrong guess moves it by degrees, and what has been
gathered along that motion is wrong for good. At the ends of *windows* of 20, 40, 80, ... readings of the encoders
everything read so far is therefore filtered once more from the first tick on, as if the muscles were as believed now.

Where the whole pose is read in every tick, one such replay in each window is enough, and 80 readings are the last
window. Where it is left open, by one point or by encoders that are slower than the ticks, the belief may settle on
more than one motion, as least squares have more than one minimum. Windows then go on to the end of the record; in
each, several starts are followed until they stay, and the one with the largest posterior density (Laplace's
approximation, with the motion integrated out) is kept.
"""

from __future__ import annotations

from math import log, sqrt

import numpy as np

from jawenv.compiled import njit, njit_within
from jawenv.estimation.measurement import N_MEASUREMENTS
from jawenv.estimation.posterior import factor_positive
from jawenv.estimation.sensitivity import N_NOISE, N_SAMPLES
from jawenv.estimation.tension_belief import begin_belief, forget_readings
from jawenv.estimation.tension_filter import tension_fields
from jawenv.estimation.tick import begin_motion, learn, take_readings
from jawenv.mechanics.dynamics import N_WRENCH

FIRST_WINDOW, LAST_WINDOW = 20, 80  # readings
N_STARTS = 4  # of the search for a belief that fits
PASSES = 4  # at most, over a window from one start, until one moves no parameter by
SMALL_STEP = 0.1  # sds or more
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
        ("best", "f8", (parameters,)),
    ]
    return np.dtype(fields, align=True)


@njit
def ends_window(belief, settings, scratch):
    """Whether readings are to be filtered again after this tick."""
    if not scratch.used.any():
        return False
    window = FIRST_WINDOW
    while window < belief.read:
        window *= 2
    return belief.read == window and (settings.pose_open or window <= LAST_WINDOW)


@njit_within
def renew(jaw, device, belief, rows, tick, settings, scratch):
    """At the end of a window: filter ``rows`` 0 to ``tick`` again about the belief, or about the best of several.

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
    set_starts(belief, settings, scratch.starts)
    search(jaw, device, belief, rows, tick, settings, scratch, scratch.starts, PASSES, SMALL_STEP)


@njit
def set_starts(belief, settings, starts):
    """The belief's mean, the prior's, and the belief's with one half of the muscles stronger and the other weaker."""
    size = starts.shape[1]
    for i in range(size):
        mean, apart = belief.belief_mean[i], 0.0
        if i % 2 == 0:
            apart = APART * settings.prior_sd[i] * (1.0 if i < size // 2 else -1.0)
        starts[0, i], starts[1, i] = mean, settings.prior_mean[i]
        starts[2, i], starts[3, i] = mean + apart, mean - apart


@njit_within
def search(jaw, device, belief, rows, tick, settings, scratch, starts, passes, small_step):
    """The belief about rows 0 to ``tick`` whose density is largest among those found from ``starts`` (S, p)."""
    best, found, last = -np.inf, -1, -1
    for s in range(starts.shape[0]):
        density, new = settle(
            jaw, device, belief, rows, tick, settings, scratch, starts[s], passes, small_step, found >= 0
        )
        last = s
        if new and density > best:
            best, found = density, s
            scratch.best[:] = scratch.about
    if found != last:
        if found < 0:
            scratch.best[:] = settings.prior_mean
        begin_belief(settings.basis, belief, scratch.best, settings.prior_sd)
        replay(jaw, device, belief, rows, tick, settings, scratch)


@njit_within
def settle(jaw, device, belief, rows, tick, settings, scratch, start, passes, small_step, known):
    """Follow a start until the belief stays where the readings were filtered about, ``about``.

    Returns:
        The logarithm of the density there, and False where it comes to the ``best`` that is ``known``, or is no number.
    """
    begin_belief(settings.basis, belief, start, settings.prior_sd)
    density = -np.inf
    for _ in range(passes):
        scratch.about[:] = belief.belief_mean
        density = replay(jaw, device, belief, rows, tick, settings, scratch)
        if not density > -np.inf:
            return density, False
        if known and distance(belief, scratch.best) < small_step:
            return density, False
        if distance(belief, scratch.about) < small_step:
            break
    return density, True


@njit
def distance(belief, parameters):
    """The largest distance of a parameter from the belief's mean, in its sds."""
    furthest = 0.0
    for i in range(parameters.shape[0]):
        furthest = max(furthest, abs(belief.belief_mean[i] - parameters[i]) / sqrt(belief.belief_cov[i, i]))
    return furthest


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
        away = (belief.belief_mean[i] - settings.prior_mean[i]) / settings.prior_sd[i]
        density -= 0.5 * away * away
    for _ in range(SEARCHES):
        learn(belief, settings, scratch)
    return density + 0.5 * log_det(belief.belief_cov, scratch.posterior.precision)


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
