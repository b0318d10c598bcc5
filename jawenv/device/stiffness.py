"""How fast the device could swing the jaw, and so how short the steps must be while it holds it.

As ``mechanics.stiffness``: with stiffness k and damping d at a point whose mobility is w, no mode is faster than
sqrt(k w) + d w.
"""

from __future__ import annotations

from math import sqrt

from jawenv.compiled import njit
from jawenv.device.device import N_MOTORS
from jawenv.device.motors import BRAKED, STOPPED


@njit
def device_rate(device, jaw, trajectory, acted):
    """Bound on the rate (1/s) that what of the governor ``acted`` gives the jaw, and position servos if ``trajectory``.

    ``acted`` as ``motors.device_wrench`` returns it.
    """
    stiffness, damping = 0.0, 0.0
    if acted >= BRAKED:
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
    return sqrt(stiffness) + damping
