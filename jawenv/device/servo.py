"""How the device's wrench answers to the jaw's motion in trajectory control: its motors' servos, linearised."""

from __future__ import annotations

from jawenv.compiled import njit
from jawenv.device.device import N_MOTORS
from jawenv.mechanics.vec3 import add, apply_transposed, cross, dot, row3


@njit
def set_servo(device, mouthpiece, by_place, body_to_head, servo):
    """Into ``servo`` (6, n), by how much the wrench at the mouthpiece falls as the jaw's state grows by a unit.

    Force (N) and moment (N m) in body axes. The thrust of each motor falls by stiffness times the advance of its point
    and by damping times its speed; caps and governor are left out.

    Args:
        device: A record of dtype ``DEVICE``.
        mouthpiece: Its place (m, body axes).
        by_place: (n / 2, 3) what the reference point moves by with each coordinate, and the axes about which the last
            three turn the body; both in body axes.
        body_to_head: Rotation from body to head axes.
        servo: (6, n), overwritten.
    """
    servo[:, :] = 0.0
    half = by_place.shape[0]
    first = half - 3
    for i in range(N_MOTORS):
        point = row3(device.point, i)
        axis = apply_transposed(body_to_head, row3(device.direction, i))
        lever, moment = cross(add(mouthpiece, point), axis), cross(point, axis)
        for c in range(half):
            way = row3(by_place, c)
            advance = dot(way, axis) if c < first else dot(way, lever)
            speed = advance if c < first else lever[c - first]
            for k in range(3):
                servo[k, c] += axis[k] * device.servo_stiffness * advance
                servo[3 + k, c] += moment[k] * device.servo_stiffness * advance
                servo[k, half + c] += axis[k] * device.servo_damping * speed
                servo[3 + k, half + c] += moment[k] * device.servo_damping * speed
