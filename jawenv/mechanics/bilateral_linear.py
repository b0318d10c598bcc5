"""Exact derivatives of the two-condyle jaw's accelerations, for the filter with two condyles.

Each column follows one small change of the motion, (dr, dphi, dv, domega): shift and turn of the body (head axes),
change of its velocity (head axes) and angular velocity (body axes), through the equations of ``bilateral``. Muscles,
gravity and teeth enter by their stiffness K, L, N (see ``forces``), each condyle by what its force does with its own
place and velocity.
"""

from __future__ import annotations

from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, dot, row3, scale, subtract, vector3
from jawenv.mechanics.dynamics import N_WRENCH, Linear, inertia_times, set_column
from jawenv.mechanics.forces import capsule_force, carried_with_stiffness, smooth_ramp
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import fossa, midline_pose, point_motion, rotation, turning_axes

UNITS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ZERO = (0.0, 0.0, 0.0)


@njit
def _disc_derivative(jaw: Jaw, point, velocity):
    """Force of a disc (head axes), and its derivatives by place and velocity as (xx, xz, zx, zz) each."""
    height, slope, curvature, third = fossa(jaw, point[0])
    above = point[2] - height
    steep = 1.0 / (1.0 + slope * slope) ** 0.5
    square = steep * steep
    width = jaw.disc_onset / jaw.disc_stiffness
    ramp, ramp_1 = smooth_ramp(above * steep, width)
    ramp_2 = 1.0 / width if 0.0 < above * steep < width else 0.0
    k, c = jaw.disc_stiffness, jaw.disc_damping
    # The gradient of the depth, and its derivative: xx and xz, as zz is 0.
    g = (-steep * slope * (1.0 + above * curvature * square), 0.0, steep)
    bend = curvature * curvature + slope * third - 3.0 * (slope * curvature * steep) ** 2
    h_xz = -slope * curvature * steep * square
    h_xx = steep * curvature * (2.0 * slope * slope * square - 1.0) - above * steep * square * bend
    rate = dot(g, velocity)
    pressure = k * ramp + c * ramp_1 * rate
    if ramp <= 0.0 or pressure <= 0.0:
        return ZERO, (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    # dN by place: elastic and viscous share along g, and the viscous share of the turning gradient.
    firm = k * ramp_1 + c * ramp_2 * rate
    n_x = firm * g[0] + c * ramp_1 * (h_xx * velocity[0] + h_xz * velocity[2])
    n_z = firm * g[2] + c * ramp_1 * h_xz * velocity[0]
    by_place = (
        -n_x * g[0] - pressure * h_xx,
        -n_z * g[0] - pressure * h_xz,
        -n_x * g[2] - pressure * h_xz,
        -n_z * g[2],
    )
    viscous = c * ramp_1
    by_velocity = (-viscous * g[0] * g[0], -viscous * g[0] * g[2], -viscous * g[2] * g[0], -viscous * g[2] * g[2])
    return scale(-pressure, g), by_place, by_velocity


@njit
def _condyle_derivative(jaw: Jaw, point, velocity):
    """Force on one condyle (as ``bilateral.condyle_force``) and its derivatives by place and velocity, 3 x 3."""
    disc, by_place, by_velocity = _disc_derivative(jaw, point, velocity)
    capsule, capsule_slope = capsule_force(jaw, point[0])
    half = 0.5 * jaw.damping_sliding
    force = add(add(disc, scale(-half, velocity)), (0.5 * capsule, 0.0, 0.0))
    stiffness = (
        (by_place[0] + 0.5 * capsule_slope, 0.0, by_place[1]),
        (0.0, 0.0, 0.0),
        (by_place[2], 0.0, by_place[3]),
    )
    damping = (
        (by_velocity[0] - half, 0.0, by_velocity[1]),
        (0.0, -half, 0.0),
        (by_velocity[2], 0.0, by_velocity[3] - half),
    )
    return force, stiffness, damping


@njit
def _condyle_change(arm, spin, force, stiffness, damping, spin_change, change):
    """Change of a condyle's force and of its moment about the midpoint, for a change (dr, dphi, dv) of the body.

    ``arm`` and ``spin`` (omega x arm) are in head axes, ``spin_change`` is its change with omega alone.
    """
    shift, turn, speed = change
    displacement = cross(turn, arm)
    velocity_change = add(add(speed, cross(turn, spin)), spin_change)
    force_change = add(apply(stiffness, add(shift, displacement)), apply(damping, velocity_change))
    return force_change, add(cross(arm, force_change), cross(displacement, force))


@njit
def linearise_body(jaw: Jaw, muscles, q, u, wrench, linear: Linear):
    """U' (six numbers) and its exact derivatives.

    Fills of ``linear`` (``Linear``) ``by_state`` (6, 12) with d u'/d(q, u) and ``by_input``
    (6, 2 m + 6) with d u'/d(log F_o, log b of each of m muscles; wrench).
    """
    stiffness = linear.stiffness
    body_to_head = rotation(midline_pose(q))
    midpoint, omega = (q[0], q[1], q[2]), (u[3], u[4], u[5])
    force, moment = carried_with_stiffness(jaw, muscles, midpoint, body_to_head, stiffness, linear.pulls)
    left, right = (0.0, jaw.condyle_half_width, 0.0), (0.0, -jaw.condyle_half_width, 0.0)
    left_arm, right_arm = apply(body_to_head, left), apply(body_to_head, right)
    left_place, left_velocity = point_motion(q, u, body_to_head, left)
    right_place, right_velocity = point_motion(q, u, body_to_head, right)
    left_force, left_k, left_c = _condyle_derivative(jaw, left_place, left_velocity)
    right_force, right_k, right_c = _condyle_derivative(jaw, right_place, right_velocity)
    force = add(force, add(left_force, right_force))
    moment = add(moment, add(cross(left_arm, left_force), cross(right_arm, right_force)))
    pull = (wrench[0], wrench[1], wrench[2])
    rho = vector3(jaw.centre_of_mass)
    inverse = (row3(jaw.inertia_inverse, 0), row3(jaw.inertia_inverse, 1), row3(jaw.inertia_inverse, 2))
    momentum = inertia_times(jaw, omega)
    in_body = add(apply_transposed(body_to_head, force), pull)
    turn = add(apply_transposed(body_to_head, moment), cross(vector3(jaw.mouthpiece), pull))
    turn = subtract(add(turn, (wrench[3], wrench[4], wrench[5])), cross(rho, in_body))
    turn = subtract(turn, add(scale(jaw.damping_rotation, omega), cross(omega, momentum)))
    spin = apply(inverse, turn)
    swing = add(cross(spin, rho), cross(omega, cross(omega, rho)))
    shift = apply(body_to_head, subtract(scale(1.0 / jaw.mass, in_body), swing))

    k = (row3(stiffness[0], 0), row3(stiffness[0], 1), row3(stiffness[0], 2))
    ell = (row3(stiffness[1], 0), row3(stiffness[1], 1), row3(stiffness[1], 2))
    n = (row3(stiffness[2], 0), row3(stiffness[2], 1), row3(stiffness[2], 2))
    left_spin, right_spin = subtract(left_velocity, (u[0], u[1], u[2])), subtract(right_velocity, (u[0], u[1], u[2]))
    axes, body = turning_axes(midline_pose(q)), (jaw.mass, rho, body_to_head, inverse)
    for j in range(12):
        d_r = UNITS[j] if j < 3 else ZERO
        d_phi = apply(body_to_head, axes[j - 3]) if 3 <= j < 6 else ZERO
        d_v = UNITS[j - 6] if 6 <= j < 9 else ZERO
        d_omega = UNITS[j - 9] if j >= 9 else ZERO
        change = (d_r, d_phi, d_v)
        left_spin_change = apply(body_to_head, cross(d_omega, left))
        right_spin_change = apply(body_to_head, cross(d_omega, right))
        l_f, l_m = _condyle_change(left_arm, left_spin, left_force, left_k, left_c, left_spin_change, change)
        r_f, r_m = _condyle_change(right_arm, right_spin, right_force, right_k, right_c, right_spin_change, change)
        d_force = add(add(apply(k, d_r), apply_transposed(ell, d_phi)), add(l_f, r_f))
        d_moment = add(add(apply(ell, d_r), apply(n, d_phi)), add(l_m, r_m))
        d_force = apply_transposed(body_to_head, subtract(d_force, cross(d_phi, force)))
        d_turn = apply_transposed(body_to_head, subtract(d_moment, cross(d_phi, moment)))
        d_turn = subtract(d_turn, add(cross(d_omega, momentum), cross(omega, inertia_times(jaw, d_omega))))
        d_turn = subtract(d_turn, scale(jaw.damping_rotation, d_omega))
        d_swing = add(cross(d_omega, cross(omega, rho)), cross(omega, cross(d_omega, rho)))
        column = _solve_body(body, d_force, d_turn, d_swing, cross(d_phi, shift))
        set_column(linear.by_state, j, column)
    _fill_body_inputs(jaw, muscles, body, linear.pulls, linear.by_input)
    return (shift[0], shift[1], shift[2], spin[0], spin[1], spin[2])


@njit
def _solve_body(body, d_force, d_turn, d_swing, d_shift):
    """Change of u' (six numbers) where force (body axes), moment about the midpoint, swing and shift change by so much.

    ``body`` is (mass, centre of mass, body to head axes, inverse of the inertia about the centre of mass).
    """
    mass, rho, body_to_head, inverse = body
    spin = apply(inverse, subtract(d_turn, cross(rho, d_force)))
    swing = add(cross(spin, rho), d_swing)
    shift = add(d_shift, apply(body_to_head, subtract(scale(1.0 / mass, d_force), swing)))
    return (shift[0], shift[1], shift[2], spin[0], spin[1], spin[2])


@njit_within
def _fill_body_inputs(jaw: Jaw, muscles, body, pulls, by_input):
    """Derivatives of u' by log F_o and log b of each muscle and by the wrench, into ``by_input`` (6, 2 m + 6)."""
    body_to_head = body[2]
    wrench_column = by_input.shape[1] - N_WRENCH
    for i in range(6):
        for j in range(wrench_column):
            by_input[i, j] = 0.0
    for line in range(muscles.shape[0] if wrench_column > 0 else 0):
        push = apply_transposed(body_to_head, (pulls[line, 0], pulls[line, 1], pulls[line, 2]))
        turn = apply_transposed(body_to_head, (pulls[line, 3], pulls[line, 4], pulls[line, 5]))
        column = _solve_body(body, push, turn, ZERO, ZERO)
        exponent = muscles[line, 1] * pulls[line, 6]
        muscle = jaw.muscle[line]
        for i in range(6):
            by_input[i, 2 * muscle] += column[i]
            by_input[i, 2 * muscle + 1] += column[i] * exponent
    mouthpiece = vector3(jaw.mouthpiece)
    for j in range(3):
        turn = cross(mouthpiece, UNITS[j])
        set_column(by_input, wrench_column + j, _solve_body(body, UNITS[j], turn, ZERO, ZERO))
        set_column(by_input, wrench_column + 3 + j, _solve_body(body, ZERO, UNITS[j], ZERO, ZERO))
