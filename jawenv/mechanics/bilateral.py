"""The jaw with two condyles: a free rigid body whose condyles press on compliant discs.

The midline model (``dynamics``) lets the condyles' midpoint slide on a line that holds it from both sides, so nothing
resists roll. Here each condyle's centre, at (0, +-half width, 0) in body axes, may press the disc against the fossa or
lift off it; AnyBody's, ArtiSynth's and Koolstra's jaws have two joints for the same reason (de Zee et al. 2007;
Hannam et al. 2008; Koolstra & van Eijden 2005).

Coordinates q = (x, y, z, theta, psi, alpha): place of the midpoint between the condyles' centres (m, head axes), Euler
angles 2-3-1 as in ``kinematics`` (rad). Speeds u = (x', y', z', omega_1, omega_2, omega_3): velocity of that point
(m/s, head axes), angular velocity (rad/s, body axes). A state is the twelve numbers (q, u).

    m (v' + C^T (omega' x rho + omega x (omega x rho))) = F
    I omega' + omega x I omega = tau - rho x C F - c omega

with tau about the midpoint and I about the centre of mass. Omega' follows from the second line alone.

The disc (Kelvin-Voigt, one-sided). With the path z(x) of the condyle's centre, depth = (z - z(x)) / sqrt(1 + z'(x)^2)
is its distance above the path to first order, and

    N = max(0, k ramp(depth) + c ramp'(depth) depth'),    force = -N grad(depth).

grad(depth) is the path's unit normal, but for a part of the order depth times curvature (at most 1 % at 0.1 mm), with
which the elastic force has a potential, so that energy is kept to rounding. The ramp is quadratic up to a depth of
onset/k, then linear. The capsule's stops and the damping of sliding are the midline model's, half at each condyle, so
that for k to infinity a symmetric motion that keeps both discs pressed is the midline model's.
"""

from __future__ import annotations

from typing import TypeAlias

from jawenv.kernels.cholesky import solve_in_place
from jawenv.kernels.compiled import njit
from jawenv.kernels.runge_kutta import plus
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, dot, row3, scale, subtract, vector3
from jawenv.mechanics.dynamics import REST_TOLERANCE, inertia_times
from jawenv.mechanics.forces import capsule_force, carried_forces, smooth_ramp
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import (
    angle_rates,
    fossa,
    midline_pose,
    point_motion,
    rotation,
    split_body,
    turning_axes,
)

Six: TypeAlias = tuple[float, float, float, float, float, float]

# Longest step (s) of the true motion: at 1 ms the bounce of the jaw on its discs, about 1000 rad/s, is resolved, and
# halving the step moves the mouthpiece by less than 0.1 um. Stiffer discs need it shorter, as 1/sqrt(k).
BODY_STEP = 1e-3
NUDGE = 1e-7  # m and rad, of the difference quotients at rest
MAX_STEPS = 2000
PATIENCE = 1e-3  # product of the step (s) and what still accelerates (m/s2, rad/s2)
LONGEST_SHIFT, LONGEST_TURN = 1e-4, 2e-3  # m and rad in one step towards rest: the discs' compression is no more


@njit
def _disc_pressure(jaw: Jaw, point, velocity):
    """Compression N (N, never negative, 0 while lifted) of the disc over a condyle, and grad(depth), head axes."""
    height, slope, curvature, _ = fossa(jaw, point[0])
    above = point[2] - height
    steep = 1.0 / (1.0 + slope * slope) ** 0.5
    gradient = (-steep * slope * (1.0 + above * curvature * steep * steep), 0.0, steep)
    ramp, steepness = smooth_ramp(above * steep, jaw.disc_onset / jaw.disc_stiffness)
    rate = dot(gradient, velocity)
    return max(0.0, jaw.disc_stiffness * ramp + jaw.disc_damping * steepness * rate), gradient


@njit
def condyle_force(jaw: Jaw, point, velocity):
    """Force (N, head axes) on one condyle whose centre is at ``point``: disc, half the capsule, half the sliding."""
    pressure, gradient = _disc_pressure(jaw, point, velocity)
    capsule, _ = capsule_force(jaw, point[0])
    force = add(scale(-pressure, gradient), scale(-0.5 * jaw.damping_sliding, velocity))
    return add(force, (0.5 * capsule, 0.0, 0.0))


@njit
def condyle_pressures(jaw: Jaw, q, u):
    """Compression (N) of the left and of the right disc; 0 exactly where the condyle has lifted off."""
    body_to_head = rotation(midline_pose(q))
    left, left_velocity = point_motion(q, u, body_to_head, (0.0, jaw.condyle_half_width, 0.0))
    right, right_velocity = point_motion(q, u, body_to_head, (0.0, -jaw.condyle_half_width, 0.0))
    return _disc_pressure(jaw, left, left_velocity)[0], _disc_pressure(jaw, right, right_velocity)[0]


@njit
def body_acceleration(jaw: Jaw, muscles, q, u, wrench):
    """U' (six numbers) for coordinates q, speeds u and the device's wrench on the mouthpiece (six, body axes)."""
    body_to_head = rotation(midline_pose(q))
    midpoint, omega = (q[0], q[1], q[2]), (u[3], u[4], u[5])
    force, moment = carried_forces(jaw, muscles, midpoint, body_to_head)
    for side in (1.0, -1.0):
        point, velocity = point_motion(q, u, body_to_head, (0.0, side * jaw.condyle_half_width, 0.0))
        push = condyle_force(jaw, point, velocity)
        force = add(force, push)
        moment = add(moment, cross(subtract(point, midpoint), push))
    pull = (wrench[0], wrench[1], wrench[2])
    rho = vector3(jaw.centre_of_mass)
    # In body axes from here on, about the centre of mass.
    force = add(apply_transposed(body_to_head, force), pull)
    turn = add(apply_transposed(body_to_head, moment), cross(vector3(jaw.mouthpiece), pull))
    turn = subtract(add(turn, (wrench[3], wrench[4], wrench[5])), cross(rho, force))
    turn = subtract(turn, add(scale(jaw.damping_rotation, omega), cross(omega, inertia_times(jaw, omega))))
    inverse = (row3(jaw.inertia_inverse, 0), row3(jaw.inertia_inverse, 1), row3(jaw.inertia_inverse, 2))
    spin = apply(inverse, turn)
    swing = add(cross(spin, rho), cross(omega, cross(omega, rho)))
    shift = apply(body_to_head, subtract(scale(1.0 / jaw.mass, force), swing))
    return (shift[0], shift[1], shift[2], spin[0], spin[1], spin[2])


@njit
def bilateral_rate(jaw: Jaw, muscles, q, u, wrench):
    """(q', u') as two tuples of six; arguments as in ``body_acceleration``."""
    rates = angle_rates(midline_pose(q), (u[3], u[4], u[5]))
    q_rate = (u[0], u[1], u[2], rates[0], rates[1], rates[2])
    return q_rate, body_acceleration(jaw, muscles, q, u, wrench)


@njit
def put_on_fossa(jaw: Jaw, pose, state):
    """Set ``state`` (12) to the midline model's ``pose`` (x, y, theta, psi, alpha), at rest, discs just touched."""
    state[0], state[1] = pose[0], pose[1]
    state[2], _, _, _ = fossa(jaw, pose[0])
    for i in range(3):
        state[3 + i] = pose[2 + i]
    for i in range(6):
        state[6 + i] = 0.0


@njit
def _largest_of(six, linear, angular):
    """Largest magnitude of three linear numbers over ``linear`` and three angular ones over ``angular``."""
    a = max(abs(six[0]), max(abs(six[1]), abs(six[2])))
    b = max(abs(six[3]), max(abs(six[4]), abs(six[5])))
    return max(a / linear, b / angular)


@njit
def fill_flow_matrix(jaw: Jaw, muscles, q, wrench, step, matrix):
    """Matrix (6, 6) of an implicit Euler step along q' = u': turning axes over ``step`` less the derivative of u'."""
    still = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for j in range(6):
        nudge = (
            NUDGE if j == 0 else 0.0,
            NUDGE if j == 1 else 0.0,
            NUDGE if j == 2 else 0.0,
            NUDGE if j == 3 else 0.0,
            NUDGE if j == 4 else 0.0,
            NUDGE if j == 5 else 0.0,
        )
        ahead = body_acceleration(jaw, muscles, plus(q, 1.0, nudge), still, wrench)
        behind = body_acceleration(jaw, muscles, plus(q, -1.0, nudge), still, wrench)
        for i in range(6):
            matrix[i, j] = (behind[i] - ahead[i]) / (2.0 * NUDGE)
    # As in ``equilibrium.settle``, the last rows are in body axes and the step is in angles.
    axes = turning_axes(midline_pose(q))
    for i in range(3):
        matrix[i, i] += 1.0 / step
        for j in range(3):
            matrix[3 + i, 3 + j] += axes[j][i] / step


@njit
def settle_bilateral(jaw: Jaw, muscles, wrench, state, matrix, right):
    """Move ``state`` (12) to rest under a constant wrench (six, body axes); returns whether it converged.

    Pseudo-transient continuation as in ``equilibrium.settle``, from the midline model's pose (``put_on_fossa``). A disc
    that is met stiffens the jaw a thousandfold, so a step after which twice as much accelerates is taken back, and
    steps stay short until little does: Newton's method alone hops between poses. ``matrix`` (6, 6) and ``right`` (6)
    are scratch.
    """
    step = 1e-4
    for i in range(6):
        state[6 + i] = 0.0
    q, still = split_body(state)
    rate = body_acceleration(jaw, muscles, q, still, wrench)
    for _ in range(MAX_STEPS):
        residual = _largest_of(rate, 1.0, 1.0)
        if residual < REST_TOLERANCE:
            return True
        fill_flow_matrix(jaw, muscles, q, wrench, step, matrix)
        for i in range(6):
            right[i] = rate[i]
        solve_in_place(matrix, right)
        change = (right[0], right[1], right[2], right[3], right[4], right[5])
        ahead = plus(q, 1.0 / max(1.0, _largest_of(change, LONGEST_SHIFT, LONGEST_TURN)), change)
        rate_ahead = body_acceleration(jaw, muscles, ahead, still, wrench)
        growth = _largest_of(rate_ahead, 1.0, 1.0) / residual
        if growth > 2.0:
            step *= 0.25
            continue
        q, rate = ahead, rate_ahead
        step = min(3.0 * step, PATIENCE / (growth * residual))
        for i in range(6):
            state[i] = q[i]
    return False
