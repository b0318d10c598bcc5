"""Readings of a mouthpiece that sits turned by a small angle, as vectors in its axes show it.

Encoders and load cell are zeroed with the teeth together, so that a ``turn`` (rad, body axes) is seen where
the jaw moves or is pulled: forces, moments, angles (as a small rotation vector) and angular velocities w are read as
w - about x w. Places and velocities are read in the head's axes, which are not turned.
"""

from __future__ import annotations

from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import cross


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
def turn_readings(turn, share, measured, result):
    """``result`` (12) = ``measured`` with angles (pitch, yaw, roll: about y, z, x) and angular velocity turned."""
    for i in range(measured.shape[0]):
        result[i] = measured[i]
    roll, pitch, yaw = turned(turn, share, measured[5], measured[3], measured[4])
    result[3], result[4], result[5] = pitch, yaw, roll
    result[9], result[10], result[11] = turned(turn, share, measured[9], measured[10], measured[11])
