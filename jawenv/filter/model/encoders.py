"""The encoders' readings of a motion, and their derivative by the motion."""

from __future__ import annotations

from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, cross, vector3
from jawenv.mechanics.dynamics import N_STATES
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, fossa, rotation, split, turning_axes

N_MEASUREMENTS = 12  # mouthpiece position, Euler angles, mouthpiece velocity, body angular velocity
N_POSE = 6  # of these, position and angles


@njit
def read_motion(jaw: Jaw, state, expected):
    """Expected measurements (12) of a motion of the midline model."""
    q, u = split(state)
    body_to_head = rotation(q)
    _, slope, _, _ = fossa(jaw, q[0])
    omega = (u[2], u[3], u[4])
    mouthpiece = vector3(jaw.mouthpiece)
    point = add(contact_point(jaw, q), apply(body_to_head, mouthpiece))
    velocity = add((u[0], u[1], slope * u[0]), apply(body_to_head, cross(omega, mouthpiece)))
    for i in range(3):
        expected[i], expected[3 + i] = point[i] - jaw.zero[i], q[2 + i]
        expected[6 + i], expected[9 + i] = velocity[i], omega[i]


@njit
def measure(jaw: Jaw, state, rows, expected):
    """Expected measurements (12) and their derivatives by the ten states, into ``rows`` (12, 10)."""
    q, u = split(state)
    body_to_head = rotation(q)
    _, slope, curvature, _ = fossa(jaw, q[0])
    omega = (u[2], u[3], u[4])
    mouthpiece = vector3(jaw.mouthpiece)
    spin = cross(omega, mouthpiece)
    read_motion(jaw, state, expected)
    for i in range(N_MEASUREMENTS):
        for j in range(N_STATES):
            rows[i, j] = 0.0
    rows[0, 0], rows[2, 0], rows[1, 1] = 1.0, slope, 1.0
    rows[8, 0] = curvature * u[0]
    rows[6, 5], rows[8, 5], rows[7, 6] = 1.0, slope, 1.0
    axes = turning_axes(q)
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for j in range(3):
        by_angle = apply(body_to_head, cross(axes[j], mouthpiece))
        velocity_by_angle = apply(body_to_head, cross(axes[j], spin))
        by_omega = apply(body_to_head, cross(units[j], mouthpiece))
        for i in range(3):
            rows[i, 2 + j] = by_angle[i]
            rows[6 + i, 2 + j] = velocity_by_angle[i]
            rows[6 + i, 7 + j] = by_omega[i]
        rows[3 + j, 2 + j] = 1.0
        rows[9 + j, 7 + j] = 1.0
