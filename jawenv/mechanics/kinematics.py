"""Where the mandible is: the condyle on its fossa and the Euler angles 2-3-1.

Coordinates q = (x, y, theta, psi, alpha): contact point forward and left (m), pitch (opening), yaw, roll (rad).
Speeds u = (x', y', omega_1, omega_2, omega_3): contact point (m/s) and angular velocity in body axes (rad/s).
The contact point is r_* = (x, y, d (cos f x - 1)), Young (2016), eq. 4.3; the rotation C of Young's eqs. 4.9-4.13
takes head axes to body axes, and its transpose is what the kernels carry.
"""

from __future__ import annotations

from math import cos, sin
from typing import TypeAlias

from jawenv.compiled import njit
from jawenv.mechanics.vec3 import Matrix, Vector

Five: TypeAlias = tuple[float, float, float, float, float]


@njit
def rotation(q: Five) -> Matrix:
    """Body to head axes, C^T = R_y(theta) R_z(psi) R_x(alpha)."""
    ct, st = cos(q[2]), sin(q[2])
    cp, sp = cos(q[3]), sin(q[3])
    ca, sa = cos(q[4]), sin(q[4])
    return (
        (ct * cp, -ct * sp * ca + st * sa, ct * sp * sa + st * ca),
        (sp, cp * ca, -cp * sa),
        (-st * cp, st * sp * ca + ct * sa, -st * sp * sa + ct * ca),
    )


@njit
def turning_axes(q: Five) -> Matrix:
    """The three body-frame axes about which theta, psi and alpha turn: omega = sum of rate times axis."""
    cp, sp = cos(q[3]), sin(q[3])
    ca, sa = cos(q[4]), sin(q[4])
    return ((sp, cp * ca, -cp * sa), (0.0, sa, ca), (1.0, 0.0, 0.0))


@njit
def angle_rates(q: Five, omega: Vector) -> Vector:
    """Rates of (theta, psi, alpha) from the body angular velocity; singular at psi = 90 degrees only."""
    cp, sp = cos(q[3]), sin(q[3])
    ca, sa = cos(q[4]), sin(q[4])
    theta_rate = (omega[1] * ca - omega[2] * sa) / cp
    return (theta_rate, omega[1] * sa + omega[2] * ca, omega[0] - theta_rate * sp)


@njit
def fossa(jaw, x):
    """Height z of the condyle's path at x and its first three derivatives."""
    d, f = jaw.fossa_drop, jaw.fossa_frequency
    c, s = cos(f * x), sin(f * x)
    return d * (c - 1.0), -d * f * s, -d * f * f * c, d * f * f * f * s


@njit
def contact_point(jaw, q):
    """Contact point r_* in head axes."""
    return (q[0], q[1], jaw.fossa_drop * (cos(jaw.fossa_frequency * q[0]) - 1.0))


@njit
def split(state):
    """State array (10 or more) as the tuples q and u."""
    return (
        (state[0], state[1], state[2], state[3], state[4]),
        (state[5], state[6], state[7], state[8], state[9]),
    )
