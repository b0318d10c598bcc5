"""Place of the mandible: the condyle on its fossa and the Euler angles 2-3-1.

Coordinates q = (x, y, theta, psi, alpha): contact point forward and left (m), pitch (opening), yaw, roll (rad).
Speeds u = (x', y', omega_1, omega_2, omega_3): contact point (m/s) and angular velocity in body axes (rad/s).
The contact point is r_* = (x, y, d (cos f x - 1)), Young (2016), eq. 4.3; the rotation C of Young's eqs. 4.9-4.13
takes head axes to body axes, and its transpose is what the kernels carry. A free mandible, as own plants move it, has
q = (x, y, z, theta, psi, alpha) and u = (x', y', z', omega) of the midpoint between its condyles.
"""

from __future__ import annotations

from typing import TypeAlias

from jawenv.kernels.compiled import njit, njit_inlined
from jawenv.kernels.vec3 import Matrix, Vector, sin_cos
from jawenv.mechanics.jaw import Jaw

Five: TypeAlias = tuple[float, float, float, float, float]


@njit_inlined
def rotation(q: Five) -> Matrix:
    """Body to head axes, C^T = R_y(theta) R_z(psi) R_x(alpha)."""
    st, ct = sin_cos(q[2])
    sp, cp = sin_cos(q[3])
    sa, ca = sin_cos(q[4])
    return (
        (ct * cp, -ct * sp * ca + st * sa, ct * sp * sa + st * ca),
        (sp, cp * ca, -cp * sa),
        (-st * cp, st * sp * ca + ct * sa, -st * sp * sa + ct * ca),
    )


@njit_inlined
def turning_axes(q: Five) -> Matrix:
    """The three body-frame axes about which theta, psi and alpha turn: omega = sum of rate times axis."""
    sp, cp = sin_cos(q[3])
    sa, ca = sin_cos(q[4])
    return ((sp, cp * ca, -cp * sa), (0.0, sa, ca), (1.0, 0.0, 0.0))


@njit_inlined
def angle_rates(q: Five, omega: Vector) -> Vector:
    """Rates of (theta, psi, alpha) from the body angular velocity; singular at psi = 90 degrees only."""
    sp, cp = sin_cos(q[3])
    sa, ca = sin_cos(q[4])
    theta_rate = (omega[1] * ca - omega[2] * sa) / cp
    return (theta_rate, omega[1] * sa + omega[2] * ca, omega[0] - theta_rate * sp)


@njit_inlined
def fossa(jaw: Jaw, x):
    """Height z of the condyle's path at x and its first three derivatives."""
    d, f = jaw.fossa_drop, jaw.fossa_frequency
    s, c = sin_cos(f * x)
    return d * (c - 1.0), -d * f * s, -d * f * f * c, d * f * f * f * s


@njit_inlined
def contact_point(jaw: Jaw, q):
    """Contact point r_* in head axes."""
    _, c = sin_cos(jaw.fossa_frequency * q[0])
    return (q[0], q[1], jaw.fossa_drop * (c - 1.0))


@njit_inlined
def split(state):
    """State array (10 or more) as the tuples q and u."""
    return (
        (state[0], state[1], state[2], state[3], state[4]),
        (state[5], state[6], state[7], state[8], state[9]),
    )


@njit
def midline_motion(jaw: Jaw, q, u):
    """The motion in the midline model's coordinates, and the lift, which that model lacks.

    Returns (x, y, theta, psi, alpha), (x', y', omega), the lift of the midpoint above the path of the fossa (m) and its
    rate (m/s).
    """
    height, slope, _, _ = fossa(jaw, q[0])
    return (q[0], q[1], q[3], q[4], q[5]), (u[0], u[1], u[3], u[4], u[5]), q[2] - height, u[2] - slope * u[0]
