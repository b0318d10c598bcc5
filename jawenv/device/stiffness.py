"""How stiff the device makes the jaw, and so how short the steps must be while it holds it.

As ``mechanics.stiffness``: stiffness k and damping d at a point of mobility w add k w and d w to bounds K and D of
the body's. A mode x'' + d_x x' + k_x x = 0 has 0 <= k_x <= K and 0 <= d_x <= D, since both are symmetric and positive:
it is no faster than sqrt(K) where it swings, and than D where it creeps.
"""

from __future__ import annotations

from math import sqrt

from jawenv.device.device import N_MOTORS, DeviceRecord
from jawenv.device.motors import BRAKED, STOPPED, STOPPED_AND_BRAKED
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
    if acted == BRAKED or acted == STOPPED_AND_BRAKED:
        damping += jaw.mouthpiece_mobility * device.brake
    if acted >= STOPPED:
        stops = jaw.mouthpiece_mobility + jaw.condyle_mobility
        stiffness += stops * device.stop_stiffness
        damping += stops * device.stop_damping
    if trajectory:
        # Half of the motors pull along the same line.
        motors = 0.5 * N_MOTORS * jaw.mouthpiece_mobility
        stiffness += motors * device.servo_stiffness
        damping += motors * device.servo_damping
    return max(sqrt(stiffness), damping)
