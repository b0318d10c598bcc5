"""How stiff the device makes the jaw, and so how short the steps must be while it holds it.

As ``mechanics.stiffness``: stiffness k and damping d at a point of mobility w add k w and d w to bounds K and D of
the body's. Motors that yield to stops and brake add their thrust's share of both, across its own direction: the sums
are not symmetric, and a mode x'' + d_x x' + k_x x = 0 with |k_x| <= K and |d_x| <= D is no faster than the root of
x^2 = D x + K.
"""

from __future__ import annotations

from math import sqrt

from jawenv.device.device import N_MOTORS, DeviceRecord
from jawenv.device.motors import BRAKED, STOPPED, STOPPED_AND_BRAKED, YIELD_FORCE
from jawenv.kernels.compiled import njit
from jawenv.mechanics.jaw import Jaw


@njit
def held_rate(device: DeviceRecord, jaw: Jaw, trajectory, acted, free_rate):
    """Bound on the rate (1/s) of a jaw of this ``free_rate``, while the device holds it.

    Args:
        device: Record of dtype ``DEVICE``.
        jaw: Record of dtype ``jaw_dtype``.
        trajectory: Whether position servos act.
        acted: What of the governor acts, as ``motors.device_wrench`` returns it.
        free_rate: Bound on the rate without the device (1/s).
    """
    stiffness, damping = free_rate * free_rate, 0.0
    # Half of the motors pull along the same line.
    abreast = 0.5 * N_MOTORS
    yielding = 1.0 + abreast * device.full_scale / YIELD_FORCE
    if acted == BRAKED or acted == STOPPED_AND_BRAKED:
        damping += yielding * jaw.mouthpiece_mobility * device.brake
    if acted >= STOPPED:
        stops = yielding * (jaw.mouthpiece_mobility + jaw.condyle_mobility)
        stiffness += stops * device.stop_stiffness
        damping += stops * device.stop_damping
    if trajectory:
        motors = abreast * jaw.mouthpiece_mobility
        stiffness += motors * device.servo_stiffness
        damping += motors * device.servo_damping
    return 0.5 * (damping + sqrt(damping * damping + 4.0 * stiffness))
