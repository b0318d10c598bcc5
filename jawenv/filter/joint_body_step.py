"""One step of the filter's model with two condyles and its exact derivative: ``joint_step`` for twelve states.

Discs are stiff: the step is always divided so that the explicit method bears them.
"""

from __future__ import annotations

from jawenv.filter.joint_step import (
    add_inputs,
    begin_derivative,
    between_samples,
    fill_angle_rate_derivatives,
    move_derivative,
    set_identity,
    set_jacobian,
    stage_share,
    with_gain,
)
from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.linalg import multiply
from jawenv.kernels.runge_kutta import runge_kutta_step, set_state
from jawenv.mechanics.bilateral import midline_pose, split_body
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
    set_jacobian(1.0, scratch.by_state, scratch.by_angle, scratch.jacobian)
    multiply(scratch.jacobian, scratch.stage, scratch.slope)
    add_inputs(scratch.slope, scratch.by_input, trend, tilt)
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


@njit_within
def joint_body_rate(q, u, stage, h, given):
    """(q', u') at a stage; moves the derivative, too, through the stage."""
    jaw, muscles, samples, trend, gain, part, parts, scratch = given
    share = stage_share(part, stage, parts)
    sample, tilt = between_samples(samples, share), 2.0 * share - 1.0
    rates, acceleration = body_rate_and_sensitivity(jaw, muscles, q, u, sample, trend, gain, tilt, scratch)
    move_derivative(stage, h, scratch)
    return (u[0], u[1], u[2], rates[0], rates[1], rates[2]), acceleration


@njit
def propagate_body_in(jaw, muscles, state, samples, trend, gain, dt, parts, scratch):
    """As ``propagate_body``, with the step divided into ``parts``, whatever the state."""
    set_identity(scratch.total)
    h = dt / parts
    for part in range(parts):
        begin_derivative(scratch)
        q, u = split_body(state)
        given = (jaw, muscles, samples, trend, gain, part, parts, scratch)
        q, u = runge_kutta_step(joint_body_rate, q, u, h, given)
        set_state(state, q, u)
