"""Equations of motion of the midline model, and their exact Jacobian.

Newton's law projected on the directions that the fossa leaves free, S = d r_*/d(x, y), and Euler's equation about the
contact point with arms measured from it:

    S^T (m a_c - F) = 0                                                       (2 rows)
    I omega' + omega x I omega + m rho x C a_c - tau + c omega = 0            (3 rows)

with a_c = S u_t' + z'' x'^2 e_z + C^T (omega' x rho + omega x (omega x rho)). The normal force never appears, and
nothing is divided by a speed or by the slope of the fossa. The device's wrench (force and moment at the mouthpiece) is
given in body axes, as the load cell in the mouthpiece feels it.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.kernels.compiled import njit, njit_inlined, njit_within
from jawenv.kernels.records import Array, record_dtype
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, row3, scale, sin_cos, subtract, vector3
from jawenv.mechanics.forces import resultant, resultant_with_stiffness
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import angle_rates, fossa, rotation, turning_axes

N_STATES = 10
N_WRENCH = 6
REST_TOLERANCE = 1e-9  # rad/s2 or m/s2, left over at equilibrium


class Linear:
    """A linearisation's results."""

    by_state: Annotated[Array, "half", "states"]  # d u'/d(q, u)
    by_input: Annotated[Array, "half", "inputs"]  # d u'/d(log F_o, log b of each muscle; wrench)
    by_angle: Annotated[Array, 3, 5]  # d(theta', psi', alpha')/d(psi, alpha, omega)
    stiffness: Annotated[Array, 3, 3, 3]  # K, L and N of all forces (``forces``)
    pulls: Annotated[Array, "lines", 7]  # force, moment and strain of each line


@cache
def linear_dtype(n_lines: int, n_states: int = N_STATES, n_muscles: int = 0) -> np.dtype[np.void]:
    """Dtype of ``Linear``.

    Args:
        n_lines: of the jaw.
        n_states: of the motion.
        n_muscles: by whose parameters is differentiated; 0 for none.
    """
    half = n_states // 2
    return record_dtype(Linear, half=half, states=n_states, inputs=2 * n_muscles + N_WRENCH, lines=n_lines)


@njit_inlined
def _inertial_coupling(jaw: Jaw, slope, body_to_head):
    """Schur form of the 5 x 5 mass matrix: W = M_tr M_rr^-1 (two rows) and the inverse of M_tt - W M_rt (2 x 2)."""
    m = jaw.mass
    x, y, z = jaw.centre_of_mass[0], jaw.centre_of_mass[1], jaw.centre_of_mass[2]
    inverse = (
        row3(jaw.inertia_contact_inverse, 0),
        row3(jaw.inertia_contact_inverse, 1),
        row3(jaw.inertia_contact_inverse, 2),
    )
    forward = (
        body_to_head[0][0] + slope * body_to_head[2][0],
        body_to_head[0][1] + slope * body_to_head[2][1],
        body_to_head[0][2] + slope * body_to_head[2][2],
    )
    # Row of M_tr for the direction s: m s . C^T (e_k x rho) = m (rho x C s)_k.
    first = scale(m, cross((x, y, z), forward))
    second = scale(m, cross((x, y, z), body_to_head[1]))
    w_first, w_second = apply(inverse, first), apply(inverse, second)
    a = m * (1.0 + slope * slope) - (w_first[0] * first[0] + w_first[1] * first[1] + w_first[2] * first[2])
    b = -(w_first[0] * second[0] + w_first[1] * second[1] + w_first[2] * second[2])
    d = m - (w_second[0] * second[0] + w_second[1] * second[1] + w_second[2] * second[2])
    return inverse, w_first, w_second, _free_inverse(jaw, a, b, d)


@njit_inlined
def _free_inverse(jaw: Jaw, a, b, d):
    """Inverse (xx, xy, yy) of the 2 x 2 block of sliding, of its free coordinates only."""
    if jaw.free_x and jaw.free_y:
        determinant = a * d - b * b
        return d / determinant, -b / determinant, a / determinant
    if jaw.free_x:
        return 1.0 / a, 0.0, 0.0
    if jaw.free_y:
        return 0.0, 0.0, 1.0 / d
    return 0.0, 0.0, 0.0


@njit_inlined
def _solve_mass(coupling, right_x, right_y, right_turn):
    """U' from M u' = (right_x, right_y, right_turn)."""
    inverse, w_first, w_second, schur = coupling
    rx = right_x - (w_first[0] * right_turn[0] + w_first[1] * right_turn[1] + w_first[2] * right_turn[2])
    ry = right_y - (w_second[0] * right_turn[0] + w_second[1] * right_turn[1] + w_second[2] * right_turn[2])
    ax = schur[0] * rx + schur[1] * ry
    ay = schur[1] * rx + schur[2] * ry
    turn = apply(inverse, right_turn)
    return (
        ax,
        ay,
        turn[0] - w_first[0] * ax - w_second[0] * ay,
        turn[1] - w_first[1] * ax - w_second[1] * ay,
        turn[2] - w_first[2] * ax - w_second[2] * ay,
    )


@njit_inlined
def inertia_times(jaw: Jaw, a):
    """Inertia about the centre of mass times a body vector."""
    return apply((row3(jaw.inertia, 0), row3(jaw.inertia, 1), row3(jaw.inertia, 2)), a)


@njit_inlined
def body_moment(jaw: Jaw, body_to_head, moment, omega, wrench):
    """Moment about the contact point in body axes: forces, device wrench, damping of rotation."""
    pull = (wrench[0], wrench[1], wrench[2])
    turn = add((wrench[3], wrench[4], wrench[5]), cross(vector3(jaw.mouthpiece), pull))
    return subtract(add(apply_transposed(body_to_head, moment), turn), scale(jaw.damping_rotation, omega))


@njit_inlined
def acceleration_kernel(jaw: Jaw, muscles, q, u, wrench):
    """U' (five numbers) for coordinates q, speeds u and the device's wrench (six numbers, body axes)."""
    body_to_head = rotation(q)
    force, moment = resultant(jaw, muscles, q, u, body_to_head)
    force = add(force, apply(body_to_head, (wrench[0], wrench[1], wrench[2])))
    _, slope, curvature, _ = fossa(jaw, q[0])
    omega = (u[2], u[3], u[4])
    rho = vector3(jaw.centre_of_mass)
    bias = add((0.0, 0.0, curvature * u[0] * u[0]), apply(body_to_head, cross(omega, cross(omega, rho))))
    effective_force = subtract(force, scale(jaw.mass, bias))
    turn = body_moment(jaw, body_to_head, moment, omega, wrench)
    turn = subtract(turn, cross(omega, inertia_times(jaw, omega)))
    turn = subtract(turn, scale(jaw.mass, cross(rho, apply_transposed(body_to_head, bias))))
    coupling = _inertial_coupling(jaw, slope, body_to_head)
    return _solve_mass(coupling, effective_force[0] + slope * effective_force[2], effective_force[1], turn)


@njit_inlined
def state_rate(jaw: Jaw, muscles, q, u, wrench):
    """(q', u') as two tuples of five."""
    rates = angle_rates(q, (u[2], u[3], u[4]))
    return (u[0], u[1], rates[0], rates[1], rates[2]), acceleration_kernel(jaw, muscles, q, u, wrench)


@njit
def linearise_acceleration(jaw: Jaw, muscles, q, u, wrench, linear: Linear):
    """U' and its exact derivatives.

    Fills of ``linear`` (``Linear``) ``by_state`` (5, 10) with d u'/d(q, u) and ``by_input``
    (5, 2 m + 6) with d u'/d(log F_o, log b of each of m muscles; wrench). The residual of the equations of motion is
    differentiated at fixed u' and solved with the mass matrix, so no derivative of that is formed.
    """
    by_state, stiffness, pulls = linear.by_state, linear.stiffness, linear.pulls
    body_to_head = rotation(q)
    force, moment = resultant_with_stiffness(jaw, muscles, q, u, body_to_head, stiffness, pulls)
    pull = (wrench[0], wrench[1], wrench[2])
    force = add(force, apply(body_to_head, pull))
    _, slope, curvature, third = fossa(jaw, q[0])
    m, c = jaw.mass, jaw.damping_sliding
    omega, rho = (u[2], u[3], u[4]), vector3(jaw.centre_of_mass)
    spin = cross(omega, rho)
    bias = add((0.0, 0.0, curvature * u[0] * u[0]), apply(body_to_head, cross(omega, spin)))
    gyro = cross(omega, inertia_times(jaw, omega))
    effective_force = subtract(force, scale(m, bias))
    turn = subtract(body_moment(jaw, body_to_head, moment, omega, wrench), gyro)
    turn = subtract(turn, scale(m, cross(rho, apply_transposed(body_to_head, bias))))
    coupling = _inertial_coupling(jaw, slope, body_to_head)
    rate = _solve_mass(coupling, effective_force[0] + slope * effective_force[2], effective_force[1], turn)

    # Everything below is at fixed u'.
    contact_acceleration = (rate[0], rate[1], slope * rate[0] + curvature * u[0] * u[0])
    swing = add(cross((rate[2], rate[3], rate[4]), rho), cross(omega, spin))
    net = subtract(scale(m, add(contact_acceleration, apply(body_to_head, swing))), force)
    contact_body = apply_transposed(body_to_head, contact_acceleration)
    moment_body = apply_transposed(body_to_head, moment)
    k = (row3(stiffness[0], 0), row3(stiffness[0], 1), row3(stiffness[0], 2))
    ell = (row3(stiffness[1], 0), row3(stiffness[1], 1), row3(stiffness[1], 2))
    n = (row3(stiffness[2], 0), row3(stiffness[2], 1), row3(stiffness[2], 2))

    # x
    vertical = curvature * rate[0] + third * u[0] * u[0]
    shift = (1.0, 0.0, slope)
    change = add(apply(k, shift), (0.0, 0.0, -c * curvature * u[0]))
    residual = subtract((0.0, 0.0, m * vertical), change)
    torque = scale(m, cross(rho, apply_transposed(body_to_head, (0.0, 0.0, vertical))))
    torque = subtract(torque, apply_transposed(body_to_head, apply(ell, shift)))
    along = residual[0] + slope * residual[2] + curvature * net[2]
    set_column(by_state, 0, _solve_mass(coupling, -along, -residual[1], scale(-1.0, torque)))
    # y
    change = (k[0][1], k[1][1], k[2][1])
    torque = apply_transposed(body_to_head, (ell[0][1], ell[1][1], ell[2][1]))
    set_column(by_state, 1, _solve_mass(coupling, change[0] + slope * change[2], change[1], torque))
    # theta, psi, alpha
    axes = turning_axes(q)
    for j in range(3):
        axis = axes[j]
        axis_head = apply(body_to_head, axis)
        change = add(apply_transposed(ell, axis_head), apply(body_to_head, cross(axis, pull)))
        residual = subtract(scale(m, apply(body_to_head, cross(axis, swing))), change)
        torque = add(scale(-m, cross(rho, cross(axis, contact_body))), cross(axis, moment_body))
        torque = subtract(torque, apply_transposed(body_to_head, apply(n, axis_head)))
        set_column(by_state, 2 + j, _solve_residual(coupling, slope, residual, torque))
    _fill_speed_columns(jaw, u, slope, curvature, body_to_head, coupling, by_state)
    _fill_input_columns(jaw, muscles, body_to_head, slope, coupling, pulls, linear.by_input)
    return rate


@njit
def set_column(matrix, j, column):
    """Column j of ``matrix``, which has as many rows as the tuple ``column`` has numbers."""
    for i in range(len(column)):
        matrix[i, j] = column[i]


@njit
def _solve_residual(coupling, slope, residual, torque):
    """U' that cancels a residual of the equations: a force (head axes) and a moment (body axes)."""
    return _solve_mass(coupling, -(residual[0] + slope * residual[2]), -residual[1], scale(-1.0, torque))


@njit_within
def _fill_speed_columns(jaw: Jaw, u, slope, curvature, body_to_head, coupling, by_state):
    """Derivatives of u' by x', y' and omega, into columns 5 to 9 of ``by_state``."""
    m, c = jaw.mass, jaw.damping_sliding
    omega = (u[2], u[3], u[4])
    rho = vector3(jaw.centre_of_mass)
    spin = cross(omega, rho)
    vertical = 2.0 * curvature * u[0]
    torque = scale(-m, cross(rho, apply_transposed(body_to_head, (0.0, 0.0, vertical))))
    set_column(by_state, 5, _solve_mass(coupling, -(c + slope * (m * vertical + c * slope)), 0.0, torque))
    set_column(by_state, 6, _solve_mass(coupling, 0.0, -c, (0.0, 0.0, 0.0)))
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    angular_momentum = inertia_times(jaw, omega)
    for j in range(3):
        unit = units[j]
        swing_change = add(cross(unit, spin), cross(omega, cross(unit, rho)))
        residual = scale(m, apply(body_to_head, swing_change))
        torque = add(cross(unit, angular_momentum), cross(omega, inertia_times(jaw, unit)))
        torque = add(add(torque, scale(m, cross(rho, swing_change))), scale(jaw.damping_rotation, unit))
        set_column(by_state, 7 + j, _solve_residual(coupling, slope, residual, torque))


@njit_within
def _fill_input_columns(jaw: Jaw, muscles, body_to_head, slope, coupling, pulls, by_input):
    """Derivatives of u' by log F_o and log b of each muscle and by the wrench, into ``by_input`` (5, 2 m + 6).

    Those of the wrench alone where ``by_input`` has six columns.
    """
    wrench_column = by_input.shape[1] - N_WRENCH
    for i in range(5):
        for j in range(wrench_column):
            by_input[i, j] = 0.0
    for line in range(muscles.shape[0] if wrench_column > 0 else 0):
        pull = (pulls[line, 0], pulls[line, 1], pulls[line, 2])
        turn = apply_transposed(body_to_head, (pulls[line, 3], pulls[line, 4], pulls[line, 5]))
        column = _solve_mass(coupling, pull[0] + slope * pull[2], pull[1], turn)
        exponent = muscles[line, 1] * pulls[line, 6]
        muscle = jaw.muscle[line]
        for i in range(5):
            by_input[i, 2 * muscle] += column[i]
            by_input[i, 2 * muscle + 1] += column[i] * exponent
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    mouthpiece = vector3(jaw.mouthpiece)
    for j in range(3):
        pull = apply(body_to_head, units[j])
        turn = cross(mouthpiece, units[j])
        set_column(by_input, wrench_column + j, _solve_mass(coupling, pull[0] + slope * pull[2], pull[1], turn))
        set_column(by_input, wrench_column + 3 + j, _solve_mass(coupling, 0.0, 0.0, units[j]))


@njit
def _fill_angle_rate_derivatives(q, omega, by_angle):
    """Derivatives of (theta', psi', alpha') by (psi, alpha, omega), into ``by_angle`` (3, 5)."""
    sp, cp = sin_cos(q[3])
    sa, ca = sin_cos(q[4])
    tangent = sp / cp
    across = omega[1] * ca - omega[2] * sa
    along = omega[1] * sa + omega[2] * ca
    by_angle[0, 0], by_angle[0, 1] = across * sp / (cp * cp), -along / cp
    by_angle[0, 2], by_angle[0, 3], by_angle[0, 4] = 0.0, ca / cp, -sa / cp
    by_angle[1, 0], by_angle[1, 1] = 0.0, across
    by_angle[1, 2], by_angle[1, 3], by_angle[1, 4] = 0.0, sa, ca
    by_angle[2, 0], by_angle[2, 1] = -across / (cp * cp), along * tangent
    by_angle[2, 2], by_angle[2, 3], by_angle[2, 4] = 1.0, -ca * tangent, sa * tangent


@njit_within
def linearised_rate(jaw: Jaw, muscles, q, u, wrench, linear: Linear):
    """(q', u') as two tuples, and into ``linear`` (``linear_dtype``) its derivatives."""
    acceleration = linearise_acceleration(jaw, muscles, q, u, wrench, linear)
    omega = (u[2], u[3], u[4])
    _fill_angle_rate_derivatives(q, omega, linear.by_angle)
    return u[:2] + angle_rates(q, omega), acceleration
