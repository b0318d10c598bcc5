"""How fast the device could swing the jaw, and so how short the steps must be while it holds it.

As ``mechanics.stiffness``: with stiffness k and damping d at a point whose mobility is w, no mode is faster than
sqrt(k w) + d w.
"""

from __future__ import annotations

from math import sqrt

from jawenv.compiled import njit
from jawenv.device.device import N_MOTORS


@njit
def device_rate(device, jaw, trajectory):
    """Bound on the rate (1/s) that working stops and brake give the jaw, and position servos if ``trajectory``."""
    stops = jaw.mouthpiece_mobility + jaw.condyle_mobility
    stiffness = stops * device.stop_stiffness
    damping = stops * device.stop_damping + jaw.mouthpiece_mobility * device.brake
    if trajectory:
        # Half of the motors pull along the same line.
        motors = 0.5 * N_MOTORS * jaw.mouthpiece_mobility
        stiffness += motors * device.servo_stiffness
        damping += motors * device.servo_damping
    return sqrt(stiffness) + damping
