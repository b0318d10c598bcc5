"""Readings of a mouthpiece that sits turned by a small angle, as vectors in its axes show it, and a cell's offset.

Encoders and load cell are zeroed with the teeth together, so that a ``turn`` (rad, body axes) is seen where
the jaw moves or is pulled: forces, moments, angles (as a small rotation vector) and angular velocities w are read as
w - about x w. Places and velocities are read in the head's axes, which are not turned.

The offset goes with the pose, by six smooth shapes of it. So does a wrench that no muscle pulls: what acts on the jaw
and is not read is an offset of the reading with the other sign.
"""

from __future__ import annotations

from jawenv.filter.belief.state import N_SHAPES
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import cross
from jawenv.mechanics.dynamics import N_WRENCH


@njit
def turned(turn, share, x, y, z):
    """The vector (x, y, z) plus ``share`` times ``turn`` (3) cross it."""
    add = cross((turn[0], turn[1], turn[2]), (x, y, z))
    return x + share * add[0], y + share * add[1], z + share * add[2]


@njit
def turn_wrench(turn, share, wrench):
    """Turn force and moment (6) in place; ``share`` is -1 for what is read, 1 back."""
    wrench[0], wrench[1], wrench[2] = turned(turn, share, wrench[0], wrench[1], wrench[2])
    wrench[3], wrench[4], wrench[5] = turned(turn, share, wrench[3], wrench[4], wrench[5])


@njit
def _shapes_of(pose):
    """1, opening, its square, slide, side and yaw of a pose, each about 1 in a wide motion."""
    opening = pose[2] / 0.2
    return 1.0, opening, opening * opening, pose[0] / 5e-3, pose[1] / 3e-3, pose[3] / 0.05


@njit
def add_offset(offset, share, pose, wrench):
    """Add to ``wrench`` (6) so many times an ``offset`` (36) at a pose."""
    shapes = _shapes_of(pose)
    for s in range(N_SHAPES):
        for k in range(N_WRENCH):
            value = offset[s * N_WRENCH + k]
            if value != 0.0:  # adding nothing would still spread what is not finite
                wrench[k] += share * shapes[s] * value


@njit
def turn_readings(turn, share, measured, result):
    """``result`` (12) = ``measured`` with angles (pitch, yaw, roll: about y, z, x) and angular velocity turned."""
    for i in range(measured.shape[0]):
        result[i] = measured[i]
    roll, pitch, yaw = turned(turn, share, measured[5], measured[3], measured[4])
    result[3], result[4], result[5] = pitch, yaw, roll
    result[9], result[10], result[11] = turned(turn, share, measured[9], measured[10], measured[11])
