"""The extended Kalman filter over motion, log-parameters and load-cell gain.

State: q and u (10, or 12 for a jaw with two condyles), natural logs of F_o and b per muscle (12 by default), relative
gain error g of the load cell (1); 23 in all by default. The sizes come with the arrays.

* The force on the jaw is the reading plus g times the recent trend of readings. A reading that multiplied g would
  let the filter take the load cell's noise for a force without effect.
* g is considered, not estimated (Schmidt 1966): its prior uncertainty spreads to everything that it touches, and is
  never thought to have become smaller. A servo makes the reading answer to errors of the estimated motion, and a filter
  that learns g from such readings learns a wrong one.
* What g makes of the readings' departure from their trend is too fast to correlate: it adds to the process noise.
* Process noise is an unmodelled wrench, constant over one step, plus the noise of the load cell, plus what first-order
  filtering neglects: the curvature of the muscles' exponentials (see ``shift_by_curvature``).
* The parameters receive a noise that decays with time (see ``parameter_variance``).

The covariance recursion is separate from the mean's, so that along the true trajectory it is the posterior Cramer-Rao
bound (Tichavsky, Muravchik & Nehorai 1998). Measurements have independent noise and are taken one by one, which
equals the joint update to rounding: all are linearised at the predicted mean.
"""

from __future__ import annotations

from math import exp, sqrt

import numpy as np

from jawenv.compiled import njit
from jawenv.estimation.body_sensitivity import propagate_body
from jawenv.estimation.measurement import N_MEASUREMENTS, expect
from jawenv.estimation.sensitivity import propagate, sensitivity_fields
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH

TREND_TIME = 0.05  # s: long beside a step, short beside a maneuver
# How often the neglected curvature counts: it is the same error from step to step, where process noise would be new. An
# error that lasts for n steps does what white noise of n times its variance does; 400 steps are 4 s.
CURVATURE_REPEATS = 400.0
LARGEST_CURVATURE = 1.0  # variance of that noise at most, in squares of a tension: beyond, no expansion holds
LARGEST_SHIFT = 3.0  # sds that one measurement may move a parameter by


def filter_size(n_muscles: int, n_states: int = N_STATES) -> int:
    """Number of the filter's states."""
    return n_states + 2 * n_muscles + 1


def filter_scratch_dtype(n_muscles: int = 6, n_lines: int = 6, n_states: int = N_STATES) -> np.dtype[np.void]:
    """Dtype of the filter's working memory."""
    n_filter = filter_size(n_muscles, n_states)
    n_columns = n_filter + N_WRENCH
    fields = [
        *sensitivity_fields(n_muscles, n_lines, n_states),
        ("muscles", "f8", (n_lines, 2)),
        ("strain", "f8", (n_muscles,)),
        ("state", "f8", (n_states,)),
        ("product", "f8", (n_states, n_columns)),
        ("turned", "f8", (n_columns, n_states)),
        ("row", "f8", (n_states,)),
        ("tension_covariance", "f8", (n_muscles, n_muscles)),
        ("rows", "f8", (N_MEASUREMENTS, n_states)),
        ("expected", "f8", (N_MEASUREMENTS,)),
        ("wrench_variance", "f8", (N_WRENCH,)),
        ("shift", "f8", (n_filter,)),
        ("gain", "f8", (n_filter,)),
    ]
    return np.dtype(fields, align=True)


@njit
def set_muscles(jaw, log_parameters, offset, muscles):
    """(F_o, b) per line from an array that holds the muscles' log-parameters from ``offset`` on."""
    for line in range(muscles.shape[0]):
        place = offset + 2 * jaw.muscle[line]
        muscles[line, 0] = exp(log_parameters[place])
        muscles[line, 1] = exp(log_parameters[place + 1])


@njit
def parameter_variance(rate, time_constant, time, dt):
    """Variance that each log-parameter receives between ``time`` and ``time + dt``.

    Its sd per square root of a second starts at ``rate`` and decays with ``time_constant``: early, while the filter
    linearises at a poor estimate, it must not believe too much; later the parameters are the constants they are.
    """
    half_life = 0.5 * time_constant
    return rate * rate * half_life * (exp(-time / half_life) - exp(-(time + dt) / half_life))


@njit
def multiply_row(left, i, right, product):
    """Row i of ``product`` = row i of ``left`` times ``right``, four rows of ``right`` at a time."""
    size = right.shape[0]
    last = size - size % 4
    for j in range(size):
        value = 0.0
        for k in range(last, size):
            value += left[i, k] * right[k, j]
        product[i, j] = value
    for k in range(0, last, 4):
        a, b, c, d = left[i, k], left[i, k + 1], left[i, k + 2], left[i, k + 3]
        for j in range(size):
            product[i, j] += a * right[k, j] + b * right[k + 1, j] + c * right[k + 2, j] + d * right[k + 3, j]


@njit
def predict_covariance(covariance, wrench_variance, parameter_noise, curvature, scratch):
    """P <- F P F^T + G W G^T + C S C^T + Q, with F and G from ``scratch.total`` as left by ``propagate``.

    C are the columns of the log-tensions and S is ``curvature`` times the squares of ``scratch.tension_covariance``.
    All three products share one pass: [F P, G W, C S] times [F, G, C]^T.
    """
    total, product, turned = scratch.total, scratch.product, scratch.turned
    size, columns, n_states = covariance.shape[0], total.shape[1], total.shape[0]
    for i in range(n_states):
        multiply_row(total, i, covariance, product)
        for k in range(columns):
            turned[k, i] = total[i, k]
    for i in range(n_states):
        for j in range(n_states, size):
            covariance[i, j] = product[i, j]
            covariance[j, i] = product[i, j]
        for k in range(N_WRENCH):
            product[i, size + k] = total[i, size + k] * wrench_variance[k]
        if curvature > 0.0:
            add_curvature(scratch.tension_covariance, curvature, total, product, i)
    for i in range(n_states):
        for j in range(n_states):
            scratch.row[j] = 0.0
        for k in range(columns):
            factor = product[i, k]
            for j in range(n_states):
                scratch.row[j] += factor * turned[k, j]
        for j in range(i + 1):
            covariance[i, j] = scratch.row[j]
            covariance[j, i] = scratch.row[j]
    for i in range(n_states, size - 1):
        covariance[i, i] += parameter_noise


@njit
def add_curvature(spread, curvature, total, product, i):
    """Add row i of C S to the columns of log F_o in ``product``."""
    first = total.shape[0]
    for a in range(spread.shape[0]):
        value = 0.0
        for b in range(spread.shape[0]):
            value += spread[a, b] * spread[a, b] * total[i, first + 2 * b]
        product[i, first + 2 * a] += curvature * value


@njit
def mean_reading(samples, k):
    """Mean of component k over a step from its three samples, by Simpson's rule."""
    return (samples[0, k] + 4.0 * samples[1, k] + samples[2, k]) / 6.0


@njit
def mean_force(samples):
    """Mean force over a step from its three samples."""
    return mean_reading(samples, 0), mean_reading(samples, 1), mean_reading(samples, 2)


@njit
def set_strains(jaw, scratch):
    """Mean exponent b (l - l_o)/l_o over the lines of each muscle, into ``scratch.strain``."""
    strain = scratch.strain
    for i in range(strain.shape[0]):
        total, lines = 0.0, 0
        for line in range(scratch.muscles.shape[0]):
            if jaw.muscle[line] == i:
                total += scratch.muscles[line, 1] * scratch.pulls[line, 6]
                lines += 1
        strain[i] = total / lines


@njit
def set_tension_covariance(covariance, scratch):
    """Covariance of the muscles' log-tensions log F_o + b (l - l_o)/l_o that the parameters' covariance implies."""
    first = scratch.total.shape[0]
    for i in range(scratch.strain.shape[0]):
        a, e = first + 2 * i, scratch.strain[i]
        for j in range(scratch.strain.shape[0]):
            b, f = first + 2 * j, scratch.strain[j]
            scratch.tension_covariance[i, j] = (
                covariance[a, b]
                + e * covariance[a + 1, b]
                + f * covariance[a, b + 1]
                + e * f * covariance[a + 1, b + 1]
            )


@njit
def curvature_weight(scratch):
    """Factor of the squared log-tension covariances in the process noise, at most ``LARGEST_CURVATURE`` in all."""
    largest = 0.0
    for k in range(scratch.strain.shape[0]):
        largest = max(largest, scratch.tension_covariance[k, k])
    return min(0.5 * CURVATURE_REPEATS, LARGEST_CURVATURE / (largest * largest))


@njit
def shift_by_curvature(mean, scratch):
    """Second-order shift of the predicted motion (Jazwinski 1970, section 9.3).

    A tension of log-variance s has a mean larger by s/2 than the value at its mean log, and an error of variance
    s^2 / 2 that the linearisation does not see (see ``predict_covariance``). Both vanish as parameters become known.
    """
    first = scratch.total.shape[0]
    for i in range(first):
        for k in range(scratch.strain.shape[0]):
            mean[i] += 0.5 * scratch.tension_covariance[k, k] * scratch.total[i, first + 2 * k]


@njit
def follow_trend(trend, samples, dt):
    """Let the load cell's trend (6) follow its samples with ``TREND_TIME``; called after they have been used."""
    follow = 1.0 - exp(-dt / TREND_TIME)
    for k in range(N_WRENCH):
        trend[k] += follow * (mean_reading(samples, k) - trend[k])


@njit
def set_wrench_variance(known, gain_variance, samples, trend, scratch):
    """Variance of the wrench not known: ``known`` (6) and the gain's share of what the trend does not follow."""
    for k in range(N_WRENCH):
        fast = mean_reading(samples, k) - trend[k]
        scratch.wrench_variance[k] = known[k] + gain_variance * fast * fast


@njit
def move(jaw, muscles, state, samples, trend, gain, dt, scratch):
    """Propagate the motion with its derivative, by the model that ``jaw`` is of."""
    if jaw.condyles == 2:
        propagate_body(jaw, muscles, state, samples, trend, gain, dt, scratch)
    else:
        propagate(jaw, muscles, state, samples, trend, gain, dt, scratch)


@njit
def predict(jaw, mean, covariance, samples, trend, dt, wrench_variance, parameter_noise, scratch):
    """Time update of ``mean`` and ``covariance``, (23) and (23, 23) by default, over one step.

    ``samples`` (3, 6) and ``trend`` (6) are the load cell's, ``wrench_variance`` (6) that of the wrench not known:
    unmodelled and load-cell noise together.
    """
    gain = mean.shape[0] - 1
    set_muscles(jaw, mean, scratch.total.shape[0], scratch.muscles)
    move(jaw, scratch.muscles, mean, samples, trend, mean[gain], dt, scratch)
    set_strains(jaw, scratch)
    set_tension_covariance(covariance, scratch)
    shift_by_curvature(mean, scratch)
    set_wrench_variance(wrench_variance, covariance[gain, gain], samples, trend, scratch)
    predict_covariance(covariance, scratch.wrench_variance, parameter_noise, curvature_weight(scratch), scratch)


@njit
def innovation_variance(covariance, row, variance, gain):
    """Variance of the innovation of one scalar measurement; leaves P h in ``gain``."""
    size = gain.shape[0]
    for j in range(size):
        gain[j] = 0.0
    for k in range(row.shape[0]):
        factor = row[k]
        if factor != 0.0:
            for j in range(size):
                gain[j] += factor * covariance[k, j]
    for k in range(row.shape[0]):
        variance += row[k] * gain[k]
    return variance


@njit
def reduce_covariance(covariance, gain, variance):
    """Covariance after a measurement whose innovation has this variance; that of the load cell's gain stays."""
    size = gain.shape[0]
    inverse = 1.0 / variance
    considered = covariance[size - 1, size - 1]
    for i in range(size):
        for j in range(size):
            # The product first: it is the same number for (i, j) and (j, i), so P stays symmetric to the bit.
            covariance[i, j] -= (gain[i] * gain[j]) * inverse
    covariance[size - 1, size - 1] = considered


@njit
def doubt(covariance, gain, variance, innovation, first):
    """Factor, 1 or more, by which an innovation is trusted less because it would move a parameter too far.

    An update that moves a parameter by more than ``LARGEST_SHIFT`` of its sd at once goes beyond where the exponentials
    are what their tangents say. Its variance is raised until it does not, as Huber's weight does with an outlier.
    """
    largest = 0.0
    for j in range(first, gain.shape[0] - 1):
        largest = max(largest, gain[j] * gain[j] / covariance[j, j])
    return max(1.0, abs(innovation) * sqrt(largest) / (LARGEST_SHIFT * variance))


@njit
def update(jaw, mean, covariance, measured, variances, used, scratch):
    """Measurement update with ``measured`` (12), noise ``variances`` (12) and ``used`` (12, bool)."""
    size = mean.shape[0]
    expect(jaw, mean, scratch.rows, scratch.expected)
    for j in range(size):
        scratch.shift[j] = 0.0
    for i in range(N_MEASUREMENTS):
        if not used[i]:
            continue
        row = scratch.rows[i]
        variance = innovation_variance(covariance, row, variances[i], scratch.gain)
        innovation = measured[i] - scratch.expected[i]
        for k in range(row.shape[0]):
            innovation -= row[k] * scratch.shift[k]
        variance *= doubt(covariance, scratch.gain, variance, innovation, row.shape[0])
        reduce_covariance(covariance, scratch.gain, variance)
        weight = innovation / variance
        for j in range(size):
            scratch.shift[j] += weight * scratch.gain[j]
    for j in range(size - 1):
        mean[j] += scratch.shift[j]


@njit
def update_covariance(jaw, state, covariance, variances, used, scratch):
    """Measurement update of the covariance alone, linearised at ``state``: the bound's half of ``update``."""
    expect(jaw, state, scratch.rows, scratch.expected)
    for i in range(N_MEASUREMENTS):
        if used[i]:
            variance = innovation_variance(covariance, scratch.rows[i], variances[i], scratch.gain)
            reduce_covariance(covariance, scratch.gain, variance)
