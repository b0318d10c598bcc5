"""One step of the filter's model: the motion by Runge and Kutta, its derivative by the exponential of one Jacobian.

The motion takes one classical Runge-Kutta step, or several where the jaw is stiff, under the wrench that the load cell
read at the start, the middle and the end of the step. The derivative is that of the linear system that is frozen half
way, x' = J x + B w with a wrench w constant over the step:

    x(h) = exp(J h) x(0) + (h + J h^2 / 2 + J^2 h^3 / 6 + ...) B w,

both series to the fourth order (Van Loan 1978, IEEE Trans. Autom. Control 23:395, for the pair of them), for a part of
the step, and composed to the whole. It needs one Jacobian where the derivative of the Runge-Kutta step itself
(``bound.joint_step``) needs four for every part.
"""

from __future__ import annotations

from functools import cache
from math import exp
from typing import Annotated

import numpy as np

from jawenv.kernels.compiled import njit, njit_inlined, njit_within
from jawenv.kernels.linalg import multiply
from jawenv.kernels.records import Array, record_dtype
from jawenv.kernels.runge_kutta import runge_kutta_step, set_state, stage_place
from jawenv.mechanics.dynamics import N_WRENCH, Linear, linear_dtype, linearised_rate, state_rate
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import split
from jawenv.mechanics.stiffness import fastest_rate, parts_needed

N_SAMPLES = 3  # of the load cell per step
N_NOISE = 2 * N_WRENCH  # columns of the wrench not known: constant over a step, and tilting
ORDER = 4  # of the series
VECTOR = 8  # numbers that the compiler's loops take at once


def padded(size: int) -> int:
    """The next multiple of ``VECTOR``: rows of products are as long, with zeros at their end."""
    return -(-size // VECTOR) * VECTOR


class Step:
    """Working memory of ``move``."""

    muscles: Annotated[Array, "lines", 2]  # F_o and b of each line
    linear: Linear
    rates: Annotated[Array, "states", "wide"]  # [J, B] times the length of a part
    power: Annotated[Array, "states", "wide"]
    product: Annotated[Array, "states", "wide"]
    part: Annotated[Array, "states", "wide"]  # derivative of the motion after a part by state and wrench at its start
    total: Annotated[Array, "states", "wide"]  # the same of the whole step


@cache
def step_dtype(n_lines: int, n_states: int) -> np.dtype[np.void]:
    """Dtype of ``Step``."""
    return record_dtype(
        Step, lines=n_lines, linear=linear_dtype(n_lines, n_states), states=n_states, wide=n_states + N_WRENCH
    )


@njit
def set_muscles(jaw: Jaw, log_parameters, muscles):
    """(F_o, b) per line into ``muscles`` (lines, 2) from the natural logs, two per muscle."""
    for line in range(muscles.shape[0]):
        index = 2 * jaw.muscle[line]
        muscles[line, 0] = exp(log_parameters[index])
        muscles[line, 1] = exp(log_parameters[index + 1])


@njit_inlined
def between_samples(samples, share):
    """The load cell's wrench at a share of the step, by the parabola through its three samples."""
    first, middle, last = (1.0 - share) * (1.0 - 2.0 * share), 4.0 * share * (1.0 - share), share * (2.0 * share - 1.0)
    return (
        first * samples[0, 0] + middle * samples[1, 0] + last * samples[2, 0],
        first * samples[0, 1] + middle * samples[1, 1] + last * samples[2, 1],
        first * samples[0, 2] + middle * samples[1, 2] + last * samples[2, 2],
        first * samples[0, 3] + middle * samples[1, 3] + last * samples[2, 3],
        first * samples[0, 4] + middle * samples[1, 4] + last * samples[2, 4],
        first * samples[0, 5] + middle * samples[1, 5] + last * samples[2, 5],
    )


@njit_inlined
def stage_share(part, stage, parts):
    """Share of the whole step at which a stage of a part is evaluated."""
    return (part + stage_place(stage)) / parts


@njit
def step_parts(jaw: Jaw, muscles, state, dt):
    """Into how many parts the step from ``state`` (n) is divided."""
    q, _ = split(state)
    return parts_needed(fastest_rate(jaw, muscles, q), dt, 1)


@njit
def set_jacobian(h, linear: Linear, jacobian):
    """Into the first n columns of ``jacobian`` (n rows) ``h`` times the derivative of the state's rate by the state.

    ``linear`` is as ``linearised_rate`` fills it.
    """
    by_state, by_angle = linear.by_state, linear.by_angle
    half, size = by_state.shape
    first = half - 3  # of the angles
    for i in range(half):
        for j in range(size):
            jacobian[i, j] = 0.0
            jacobian[half + i, j] = h * by_state[i, j]
    for i in range(first):
        jacobian[i, half + i] = h
    for i in range(3):
        jacobian[first + i, first + 1], jacobian[first + i, first + 2] = h * by_angle[i, 0], h * by_angle[i, 1]
        for j in range(3):
            jacobian[first + i, half + first + j] = h * by_angle[i, 2 + j]


@njit
def _set_rates(h, scratch: Step):
    """Into ``rates`` (n, n + 6) h times the derivative of the state's rate by state and wrench."""
    rates, by_wrench = scratch.rates, scratch.linear.by_input
    set_jacobian(h, scratch.linear, rates)
    size = rates.shape[0]
    half = size // 2
    for i in range(half):
        for k in range(N_WRENCH):
            rates[i, size + k] = 0.0
            rates[half + i, size + k] = h * by_wrench[i, k]


@njit
def set_part(h, scratch: Step):
    """Into ``part`` (n, n + 6) both series of a part of ``h`` seconds."""
    rates, power, product, part = scratch.rates, scratch.power, scratch.product, scratch.part
    size, columns = part.shape
    _set_rates(h, scratch)
    power[:, :] = rates
    part[:, :] = rates
    for i in range(size):
        part[i, i] += 1.0
    for order in range(2, ORDER + 1):
        multiply(rates, power, product)
        factor = 1.0 / order
        for i in range(size):
            for j in range(columns):
                power[i, j] = factor * product[i, j]
                part[i, j] += power[i, j]


@njit
def append_part(first, scratch: Step):
    """``total`` (n, n + 6) becomes the derivative of all parts up to this one, which may be the first."""
    part, total, product = scratch.part, scratch.total, scratch.product
    size, columns = part.shape
    if first:
        total[:, :] = part
        return
    multiply(part, total, product)
    for i in range(size):
        for j in range(size):
            total[i, j] = product[i, j]
        for j in range(size, columns):
            total[i, j] = product[i, j] + part[i, j]


@njit
def _is_half_way(part, stage, parts):
    """Whether a stage of Runge and Kutta is the one at the middle of the step: the last where there are two."""
    return part == parts // 2 and stage == (2 if parts % 2 == 1 else 0)


@njit_within
def midline_rate(q, u, stage, h, arguments):
    """(q', u') of the midline model; half way through the step also the Jacobian, into ``scratch``."""
    jaw, samples, part, parts, derive, scratch = arguments
    sample = between_samples(samples, stage_share(part, stage, parts))
    if not (derive and _is_half_way(part, stage, parts)):
        return state_rate(jaw, scratch.muscles, q, u, sample)
    return linearised_rate(jaw, scratch.muscles, q, u, sample, scratch.linear)


@njit_within
def move(jaw: Jaw, motion, samples, dt, derive, scratch: Step):
    """Move ``motion`` (10) of the midline model through a step; ``derive``: its derivative, into ``total``."""
    parts = step_parts(jaw, scratch.muscles, motion, dt)
    h = dt / parts
    for part in range(parts):
        q, u = split(motion)
        q, u = runge_kutta_step(midline_rate, q, u, h, (jaw, samples, part, parts, derive, scratch))
        set_state(motion, q, u)
    if derive:
        set_part(h, scratch)
        for part in range(parts):
            append_part(part == 0, scratch)


@njit
def predict_cov(covariance, noise_variance, scratch):
    """P <- F P F^T + G W G^T, where only the first states move: F and G of these, side by side, are ``scratch.total``.

    ``noise_variance`` is W's diagonal. The moving states' block is one product: [F P, G W] times [F, G]^T.
    """
    total, weighted, moved = scratch.total, scratch.weighted, scratch.moved_cov
    size, columns, moving = covariance.shape[0], total.shape[1], total.shape[0]
    multiply(total, covariance, moved)
    for i in range(moving):
        for j in range(size):
            weighted[i, j] = moved[i, j]
        for k in range(size, columns):
            weighted[i, k] = total[i, k] * noise_variance[k - size]
        for k in range(columns):
            scratch.turned[k, i] = total[i, k]
    multiply(weighted, scratch.turned, scratch.next_cov)
    for i in range(moving):
        for j in range(moving):
            # One of two numbers that differ by rounding, so that P stays symmetric.
            covariance[i, j] = scratch.next_cov[max(i, j), min(i, j)]
        for j in range(moving, size):
            covariance[i, j] = moved[i, j]
            covariance[j, i] = moved[i, j]
