"""One step of the model and its exact derivative, which the bound and the reference filters share.

The model is one classical Runge-Kutta step, or a few if the jaw is stiff. Its wrench is what the
load cell read at the start, the middle and the end of the step: a stiff servo changes its force within a step, and with
the mean alone the predicted motion is off by a quarter of its change. The derivative is the same step applied to the
variational equation, so that it is the derivative of the numbers that the filter computes, to rounding.

Of the wrench not known there are two sets of columns: constant over the step, and tilting from -1 to 1. The noise of
three samples, with the weights 1/6, 4/6, 1/6 of Simpson's rule, acts as both do if each has the variance of the mean:
exactly, where the response is a straight line over the step. A jaw on its teeth swings by 1.9 rad in a step; there they
leave a tenth of that variance, and the constant one alone leaves up to four fifths.
"""

from __future__ import annotations

from typing import Annotated

from jawenv.filter.model.motion_step import N_NOISE, between_samples, set_jacobian, stage_share, step_parts
from jawenv.kernels.compiled import njit, njit_inlined, njit_within
from jawenv.kernels.linalg import add_scaled, multiply
from jawenv.kernels.records import Array
from jawenv.kernels.runge_kutta import STAGES, runge_kutta_step, set_state, stage_reach, stage_weight
from jawenv.mechanics.dynamics import N_WRENCH, Linear, linearised_rate
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import split


class Sensitivity:
    """Working memory of ``propagate``.

    Columns of the derivative: the states of motion, log F_o and log b of each muscle, the load cell's gain, the
    wrench not known.
    """

    linear: Linear
    jacobian: Annotated[Array, "states", "states"]
    start: Annotated[Array, "states", "columns"]
    stage: Annotated[Array, "states", "columns"]
    slope: Annotated[Array, "states", "columns"]
    total: Annotated[Array, "states", "columns"]


@njit
def _with_gain(sample, trend, gain):
    """The wrench that a sample of the load cell stands for, given the gain's error."""
    return (
        sample[0] + gain * trend[0],
        sample[1] + gain * trend[1],
        sample[2] + gain * trend[2],
        sample[3] + gain * trend[3],
        sample[4] + gain * trend[4],
        sample[5] + gain * trend[5],
    )


@njit_within
def _add_inputs(slope, by_input, trend, tilt):
    """Add what parameters, gain and wrench do to the accelerations, the lower half of ``slope``.

    ``tilt`` is where in the step, from -1 to 1.
    """
    n_states = slope.shape[0]
    first, wrenches = n_states // 2, slope.shape[1] - N_NOISE
    parameters = wrenches - 1 - n_states
    for i in range(first):
        for j in range(parameters):
            slope[first + i, n_states + j] += by_input[i, j]
        for j in range(N_WRENCH):
            slope[first + i, wrenches + j] += by_input[i, parameters + j]
            slope[first + i, wrenches + N_WRENCH + j] += tilt * by_input[i, parameters + j]
            slope[first + i, wrenches - 1] += trend[j] * by_input[i, parameters + j]


@njit
def _set_identity(matrix):
    """Ones on the diagonal of the leading square block, zeros elsewhere."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            matrix[i, j] = 0.0
        matrix[i, i] = 1.0


@njit
def copy_matrix(target, source):
    """Target = source for two arrays of the same shape."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@njit_within
def _joint_rate(q, u, stage, h, arguments):
    """(q', u') at a stage; moves the derivative, too, through the stage."""
    jaw, muscles, (samples, trend, gain), part, parts, scratch = arguments
    share = stage_share(part, stage, parts)
    wrench = _with_gain(between_samples(samples, share), trend, gain)
    rate = linearised_rate(jaw, muscles, q, u, wrench, scratch.linear)
    set_jacobian(1.0, scratch.linear, scratch.jacobian)
    multiply(scratch.jacobian, scratch.stage, scratch.slope)
    _add_inputs(scratch.slope, scratch.linear.by_input, trend, 2.0 * share - 1.0)
    _move_derivative(stage, h, scratch)
    return rate


@njit
def _begin_derivative(scratch: Sensitivity):
    """The derivative at the start of a Runge-Kutta step is what the parts before have left."""
    copy_matrix(scratch.start, scratch.total)
    copy_matrix(scratch.stage, scratch.total)


@njit_inlined
def _move_derivative(stage, h, scratch: Sensitivity):
    """The derivative through a stage, whose rate is ``slope``: as the state in ``runge_kutta_step``."""
    add_scaled(scratch.total, scratch.total, stage_weight(stage, h), scratch.slope)
    if stage < STAGES - 1:
        add_scaled(scratch.stage, scratch.start, stage_reach(stage, h), scratch.slope)


@njit
def propagate(jaw: Jaw, muscles, state, samples, trend, gain, dt, scratch: Sensitivity):
    """Advance ``state`` (n) in place by one step and fill ``scratch.total`` with its derivative, (10, 35) by default.

    ``samples`` (3, 6) are the load cell's readings at the start, middle and end of the step. The wrench is the reading
    + g ``trend``, with g the gain error ``gain`` and ``trend`` (6) the recent trend of the load cell. A jaw that is
    stiff takes the step in parts (``parts_needed``).
    """
    parts = step_parts(jaw, muscles, state, dt)
    _set_identity(scratch.total)
    h = dt / parts
    for part in range(parts):
        _begin_derivative(scratch)
        q, u = split(state)
        arguments = (jaw, muscles, (samples, trend, gain), part, parts, scratch)
        q, u = runge_kutta_step(_joint_rate, q, u, h, arguments)
        set_state(state, q, u)
