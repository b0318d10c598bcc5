"""One step of the filter's model with two condyles and its exact derivative: ``joint_step`` for twelve states.

Discs are stiff: the step is always divided so that the explicit method bears them.
"""

from __future__ import annotations

from jawenv.filter.joint_step import (
    accumulate,
    add_inputs,
    between_samples,
    combine,
    copy_matrix,
    fill_angle_rate_derivatives,
    set_identity,
    stage_share,
    with_gain,
)
from jawenv.kernels.compiled import njit, njit_within
from jawenv.mechanics.bilateral import N_BODY, midline_pose, plus_six, split_body
from jawenv.mechanics.bilateral_linear import linearise_body
from jawenv.mechanics.kinematics import angle_rates
from jawenv.mechanics.stiffness import fastest_rate, parts_needed

BODY_PARTS = 5  # of a 10 ms step: 2 ms, where the bounce on the discs, about 1000 rad/s, is stable and damped


@njit_within
def body_rate_and_sensitivity(jaw, muscles, q, u, sample, trend, gain, tilt, scratch):
    """(q', u') at a stage, and into ``scratch.slope`` its derivative given the stage's own in ``scratch.stage``."""
    wrench = with_gain(sample, trend, gain)
    acceleration = linearise_body(
        jaw, muscles, q, u, wrench, scratch.by_state, scratch.by_input, scratch.stiffness, scratch.pulls
    )
    omega = (u[3], u[4], u[5])
    pose = midline_pose(q)
    fill_angle_rate_derivatives(pose, omega, scratch.by_angle)
    stage, slope, by_state, by_angle = scratch.stage, scratch.slope, scratch.by_state, scratch.by_angle
    columns = slope.shape[1]
    for i in range(3):
        a, b = by_angle[i, 0], by_angle[i, 1]
        c, d, e = by_angle[i, 2], by_angle[i, 3], by_angle[i, 4]
        for j in range(columns):
            slope[i, j] = stage[6 + i, j]
            slope[3 + i, j] = a * stage[4, j] + b * stage[5, j] + c * stage[9, j] + d * stage[10, j] + e * stage[11, j]
    for i in range(6):
        for j in range(columns):
            slope[6 + i, j] = 0.0
        for k in range(0, N_BODY, 4):
            a, b, c, d = by_state[i, k], by_state[i, k + 1], by_state[i, k + 2], by_state[i, k + 3]
            for j in range(columns):
                slope[6 + i, j] += a * stage[k, j] + b * stage[k + 1, j] + c * stage[k + 2, j] + d * stage[k + 3, j]
    add_inputs(slope, scratch.by_input, trend, tilt)
    return angle_rates(pose, omega), acceleration


@njit
def body_step_parts(jaw, muscles, state, dt):
    """Into how many parts the step from ``state`` (12) is divided."""
    q, _ = split_body(state)
    return parts_needed(fastest_rate(jaw, muscles, midline_pose(q)), dt, BODY_PARTS)


@njit_within
def propagate_body(jaw, muscles, state, samples, trend, gain, dt, scratch):
    """Advance ``state`` (12) in place by one step and fill ``scratch.total`` with its derivative.

    Arguments as in ``joint_step.propagate``.
    """
    propagate_body_in(jaw, muscles, state, samples, trend, gain, dt, body_step_parts(jaw, muscles, state, dt), scratch)


@njit
def propagate_body_in(jaw, muscles, state, samples, trend, gain, dt, parts, scratch):
    """As ``propagate_body``, with the step divided into ``parts``, whatever the state."""
    set_identity(scratch.total)
    h = dt / parts
    for part in range(parts):
        copy_matrix(scratch.start, scratch.total)
        copy_matrix(scratch.stage, scratch.total)
        start_q, start_u = split_body(state)
        q, u = start_q, start_u
        sum_q, sum_u = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        for step in range(4):
            share = stage_share(part, step, parts)
            sample, tilt = between_samples(samples, share), 2.0 * share - 1.0
            rates, acceleration = body_rate_and_sensitivity(jaw, muscles, q, u, sample, trend, gain, tilt, scratch)
            velocity = (u[0], u[1], u[2], rates[0], rates[1], rates[2])
            weight = h / 3.0 if step == 1 or step == 2 else h / 6.0
            sum_q, sum_u = plus_six(sum_q, weight, velocity), plus_six(sum_u, weight, acceleration)
            accumulate(scratch.total, weight, scratch.slope)
            if step < 3:
                reach = h if step == 2 else 0.5 * h
                q, u = plus_six(start_q, reach, velocity), plus_six(start_u, reach, acceleration)
                combine(scratch.stage, scratch.start, reach, scratch.slope)
        for i in range(6):
            state[i] = start_q[i] + sum_q[i]
            state[6 + i] = start_u[i] + sum_u[i]
