"""The extended Kalman filter over motion, log-parameters and load-cell gain.

State (23): q and u (10), natural logs of F_o and b per muscle (12), relative gain error g of the load cell (1). The
force on the jaw is (1 + g) times the reading. Process noise is an unmodelled wrench, constant over one step, plus the
noise of the load cell; the parameters receive a noise that decays with time (see ``parameter_variance``).

The covariance recursion is separate from the mean's, so that along the true trajectory it is the posterior Cramer-Rao
bound (Tichavsky, Muravchik & Nehorai 1998). Measurements have independent noise and are taken one by one, which
equals the joint update to rounding: all are linearised at the predicted mean.
"""

from __future__ import annotations

from math import exp

import numpy as np

from jawenv.compiled import njit
from jawenv.estimation.sensitivity import N_COLUMNS, SENSITIVITY_SCRATCH, propagate
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH
from jawenv.mechanics.jaw import N_MUSCLES, N_PARAMETERS
from jawenv.mechanics.kinematics import contact_point, fossa, rotation, split, turning_axes
from jawenv.mechanics.vec3 import add, apply, cross, vector3

N_GAIN = 1
GAIN = N_STATES + N_PARAMETERS
N_FILTER = N_STATES + N_PARAMETERS + N_GAIN
N_MEASUREMENTS = 12  # mouthpiece position, Euler angles, mouthpiece velocity, body angular velocity
WRENCH_COLUMN = N_STATES + N_PARAMETERS

FILTER_SCRATCH = np.dtype(
    [
        *SENSITIVITY_SCRATCH,
        ("muscles", "f8", (N_MUSCLES, 2)),
        ("state", "f8", N_STATES),
        ("transition", "f8", (N_STATES, N_FILTER)),
        ("product", "f8", (N_STATES, N_FILTER)),
        ("rows", "f8", (N_MEASUREMENTS, N_STATES)),
        ("expected", "f8", N_MEASUREMENTS),
        ("shift", "f8", N_FILTER),
        ("gain", "f8", N_FILTER),
    ],
    align=True,
)


@njit
def set_muscles(log_parameters, offset, muscles):  # type: ignore[no-untyped-def]
    """(F_o, b) per muscle from an array that holds the log-parameters from ``offset`` on."""
    for i in range(N_MUSCLES):
        muscles[i, 0] = exp(log_parameters[offset + 2 * i])
        muscles[i, 1] = exp(log_parameters[offset + 2 * i + 1])


@njit
def parameter_variance(rate, time_constant, time, dt):  # type: ignore[no-untyped-def]
    """Variance that each log-parameter receives between ``time`` and ``time + dt``.

    Its sd per square root of a second starts at ``rate`` and decays with ``time_constant``: early, while the filter
    linearises at a poor estimate, it must not believe too much; later the parameters are the constants they are.
    """
    half_life = 0.5 * time_constant
    return rate * rate * half_life * (exp(-time / half_life) - exp(-(time + dt) / half_life))


@njit
def multiply_row(left, i, right, product):  # type: ignore[no-untyped-def]
    """Row i of ``product`` = row i of ``left`` times ``right``, four rows of ``right`` at a time."""
    last = N_FILTER - N_FILTER % 4
    for j in range(N_FILTER):
        value = 0.0
        for k in range(last, N_FILTER):
            value += left[i, k] * right[k, j]
        product[i, j] = value
    for k in range(0, last, 4):
        a, b, c, d = left[i, k], left[i, k + 1], left[i, k + 2], left[i, k + 3]
        for j in range(N_FILTER):
            product[i, j] += a * right[k, j] + b * right[k + 1, j] + c * right[k + 2, j] + d * right[k + 3, j]


@njit
def predict_covariance(covariance, reading, wrench_variance, parameter_noise, scratch):  # type: ignore[no-untyped-def]
    """P <- F P F^T + G W G^T + Q, with F and G from ``scratch.total`` as left by ``propagate``."""
    total, transition, product = scratch.total, scratch.transition, scratch.product
    for i in range(N_STATES):
        for j in range(WRENCH_COLUMN):
            transition[i, j] = total[i, j]
        by_gain = 0.0
        for k in range(N_WRENCH):
            by_gain += total[i, WRENCH_COLUMN + k] * reading[k]
        transition[i, GAIN] = by_gain
        multiply_row(transition, i, covariance, product)
    for i in range(N_STATES):
        for j in range(i + 1):
            value = 0.0
            for k in range(N_FILTER):
                value += product[i, k] * transition[j, k]
            for k in range(N_WRENCH):
                value += total[i, WRENCH_COLUMN + k] * total[j, WRENCH_COLUMN + k] * wrench_variance[k]
            covariance[i, j] = value
            covariance[j, i] = value
        for j in range(N_STATES, N_FILTER):
            covariance[i, j] = product[i, j]
            covariance[j, i] = product[i, j]
    for i in range(N_STATES, GAIN):
        covariance[i, i] += parameter_noise


@njit
def predict(jaw, mean, covariance, reading, dt, wrench_variance, parameter_noise, scratch):  # type: ignore[no-untyped-def]
    """Time update of ``mean`` (23) and ``covariance`` (23, 23) over one step with the load cell's reading (6)."""
    set_muscles(mean, N_STATES, scratch.muscles)
    factor = 1.0 + mean[GAIN]
    wrench = (
        factor * reading[0],
        factor * reading[1],
        factor * reading[2],
        factor * reading[3],
        factor * reading[4],
        factor * reading[5],
    )
    propagate(jaw, scratch.muscles, mean, wrench, dt, scratch)
    predict_covariance(covariance, reading, wrench_variance, parameter_noise, scratch)


@njit
def measure(jaw, state, rows, expected):  # type: ignore[no-untyped-def]
    """Expected measurements (12) and their derivatives by the ten states, into ``rows`` (12, 10)."""
    q, u = split(state)
    body_to_head = rotation(q)
    _, slope, curvature, _ = fossa(jaw, q[0])
    omega = (u[2], u[3], u[4])
    mouthpiece = vector3(jaw.mouthpiece)
    spin = cross(omega, mouthpiece)
    place = add(contact_point(jaw, q), apply(body_to_head, mouthpiece))
    velocity = add((u[0], u[1], slope * u[0]), apply(body_to_head, spin))
    for i in range(3):
        expected[i], expected[3 + i] = place[i], q[2 + i]
        expected[6 + i], expected[9 + i] = velocity[i], omega[i]
    for i in range(N_MEASUREMENTS):
        for j in range(N_STATES):
            rows[i, j] = 0.0
    rows[0, 0], rows[2, 0], rows[1, 1] = 1.0, slope, 1.0
    rows[8, 0] = curvature * u[0]
    rows[6, 5], rows[8, 5], rows[7, 6] = 1.0, slope, 1.0
    axes = turning_axes(q)
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for j in range(3):
        by_angle = apply(body_to_head, cross(axes[j], mouthpiece))
        velocity_by_angle = apply(body_to_head, cross(axes[j], spin))
        by_omega = apply(body_to_head, cross(units[j], mouthpiece))
        for i in range(3):
            rows[i, 2 + j] = by_angle[i]
            rows[6 + i, 2 + j] = velocity_by_angle[i]
            rows[6 + i, 7 + j] = by_omega[i]
        rows[3 + j, 2 + j] = 1.0
        rows[9 + j, 7 + j] = 1.0


@njit
def assimilate(covariance, row, variance, gain):  # type: ignore[no-untyped-def]
    """Covariance after one scalar measurement; returns the innovation's variance and leaves P h in ``gain`` (23)."""
    for j in range(N_FILTER):
        gain[j] = 0.0
    for k in range(N_STATES):
        factor = row[k]
        if factor != 0.0:
            for j in range(N_FILTER):
                gain[j] += factor * covariance[k, j]
    innovation_variance = variance
    for k in range(N_STATES):
        innovation_variance += row[k] * gain[k]
    inverse = 1.0 / innovation_variance
    for i in range(N_FILTER):
        for j in range(N_FILTER):
            # The product first: it is the same number for (i, j) and (j, i), so P stays symmetric to the bit.
            covariance[i, j] -= (gain[i] * gain[j]) * inverse
    return innovation_variance


@njit
def update(jaw, mean, covariance, measured, variances, used, scratch):  # type: ignore[no-untyped-def]
    """Measurement update with ``measured`` (12), noise ``variances`` (12) and ``used`` (12, bool)."""
    measure(jaw, mean, scratch.rows, scratch.expected)
    for j in range(N_FILTER):
        scratch.shift[j] = 0.0
    for i in range(N_MEASUREMENTS):
        if not used[i]:
            continue
        row = scratch.rows[i]
        variance = assimilate(covariance, row, variances[i], scratch.gain)
        innovation = measured[i] - scratch.expected[i]
        for k in range(N_STATES):
            innovation -= row[k] * scratch.shift[k]
        weight = innovation / variance
        for j in range(N_FILTER):
            scratch.shift[j] += weight * scratch.gain[j]
    for j in range(N_FILTER):
        mean[j] += scratch.shift[j]


@njit
def update_covariance(jaw, state, covariance, variances, used, scratch):  # type: ignore[no-untyped-def]
    """Measurement update of the covariance alone, linearised at ``state``: the bound's half of ``update``."""
    measure(jaw, state, scratch.rows, scratch.expected)
    for i in range(N_MEASUREMENTS):
        if used[i]:
            assimilate(covariance, scratch.rows[i], variances[i], scratch.gain)


__all__ = ["N_COLUMNS", "FILTER_SCRATCH", "N_FILTER", "N_MEASUREMENTS", "predict", "update"]
