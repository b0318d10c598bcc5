"""Regressors of the filter: the wrench at the mouthpiece per unit of each tension coefficient.

Lines of action are taken half way through the filter's tick. The gain error's wrench is the reading that the equations
of motion need, as a balance of forces.
"""

from __future__ import annotations

from math import exp

from jawenv.filter.model.basis import Basis
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, norm, row3, scale, subtract, vector3
from jawenv.mechanics.dynamics import N_WRENCH, body_moment, inertia_times
from jawenv.mechanics.forces import resultant
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, fossa, rotation


@njit
def middle_of(jaw: Jaw, before, after):
    """The pose half way between two states, as the midline model's five coordinates, and the reference point there."""
    pose = (
        0.5 * (before[0] + after[0]),
        0.5 * (before[1] + after[1]),
        0.5 * (before[2] + after[2]),
        0.5 * (before[3] + after[3]),
        0.5 * (before[4] + after[4]),
    )
    return pose, contact_point(jaw, pose)


@njit
def set_line_wrenches(jaw: Jaw, basis: Basis, trend, pose, position, line_wrench):
    """Into ``line_wrench`` (6, columns) the wrench (body axes) of each coefficient, and the gain error's, ``trend``.

    ``pose`` and ``position`` are those of ``middle_of``. A line's wrench is one direction times the basis functions of
    its muscle at its strain.
    """
    nodes = basis.nodes.shape[1]
    line_wrench[:, :] = 0.0
    for k in range(N_WRENCH):
        line_wrench[k, basis.nodes.shape[0] * nodes] = trend[k]
    body_to_head, mouthpiece = rotation(pose), vector3(jaw.mouthpiece)
    for line in range(jaw.origin.shape[0]):
        insertion = row3(jaw.insertion, line)
        reach = subtract(row3(jaw.origin, line), add(position, apply(body_to_head, insertion)))
        length = norm(reach)
        pull = apply_transposed(body_to_head, scale(1.0 / length, reach))
        turn = cross(subtract(insertion, mouthpiece), pull)
        muscle = jaw.muscle[line]
        strain = length / jaw.l_o[line] - 1.0 - basis.centre[muscle]
        for k in range(nodes):
            share, column = exp(basis.nodes[muscle, k] * strain), muscle * nodes + k
            for i in range(3):
                line_wrench[i, column] += share * pull[i]
                line_wrench[3 + i, column] += share * turn[i]


@njit
def inertia(jaw: Jaw, q, u, rate, body_to_head):
    """Force (head axes) and moment about the contact point (body axes) that the motion needs."""
    _, slope, curvature, _ = fossa(jaw, q[0])
    omega, rho = (u[2], u[3], u[4]), vector3(jaw.centre_of_mass)
    turning = (rate[2], rate[3], rate[4])
    swing = add(cross(turning, rho), cross(omega, cross(omega, rho)))
    contact = (rate[0], rate[1], slope * rate[0] + curvature * u[0] * u[0])
    force = scale(jaw.mass, add(contact, apply(body_to_head, swing)))
    turn = add(inertia_times(jaw, turning), cross(omega, inertia_times(jaw, omega)))
    return force, add(turn, cross(rho, apply_transposed(body_to_head, force)))


@njit
def left_over(jaw: Jaw, muscles, q, u, wrench, rate):
    """Force on the two ways of sliding (two numbers) and moment about the contact point (body axes) left over by u'."""
    body_to_head = rotation(q)
    force, moment = resultant(jaw, muscles, q, u, body_to_head)
    force = add(force, apply(body_to_head, (wrench[0], wrench[1], wrench[2])))
    _, slope, _, _ = fossa(jaw, q[0])
    inertial, inertial_turn = inertia(jaw, q, u, rate, body_to_head)
    net = subtract(force, inertial)
    turn = subtract(body_moment(jaw, body_to_head, moment, (u[2], u[3], u[4]), wrench), inertial_turn)
    return net[0] + slope * net[2], net[1], turn


@njit
def at_mouthpiece(jaw: Jaw, q, x, y, turn):
    """Force and moment at the mouthpiece (body axes) that act as ``left_over`` has it."""
    _, slope, _, _ = fossa(jaw, q[0])
    along = x / (1.0 + slope * slope)
    pull = apply_transposed(rotation(q), (along, y, slope * along))
    return pull, subtract(turn, cross(vector3(jaw.mouthpiece), pull))


@njit
def set_balanced(jaw: Jaw, muscles, pose, u, reading, balanced):
    """Set ``balanced`` (6) to the ``reading`` (6) less what it leaves over of a jaw at ``pose`` without acceleration.

    A load cell reads within milliseconds what servo, brake or stop answer to the true motion, so that even a reading of
    ticks before is correlated with the error of the filtered motion. What a motion of the past needs is not.
    """
    rest = (0.0, 0.0, 0.0, 0.0, 0.0)
    wrench = (reading[0], reading[1], reading[2], reading[3], reading[4], reading[5])
    x, y, turn = left_over(jaw, muscles, pose, u, wrench, rest)
    pull, moment = at_mouthpiece(jaw, pose, x, y, turn)
    for i in range(3):
        balanced[i] = reading[i] - pull[i]
        balanced[3 + i] = reading[3 + i] - moment[i]


@njit
def set_accelerating(jaw: Jaw, pose, rate, wrench):
    """Into ``wrench`` (6) what accelerates a jaw from rest at ``pose`` by ``rate`` (u')."""
    body_to_head = rotation(pose)
    force, turn = inertia(jaw, pose, (0.0, 0.0, 0.0, 0.0, 0.0), rate, body_to_head)
    _, slope, _, _ = fossa(jaw, pose[0])
    pull, moment = at_mouthpiece(jaw, pose, force[0] + slope * force[2], force[1], turn)
    for i in range(3):
        wrench[i] = pull[i]
        wrench[3 + i] = moment[i]
