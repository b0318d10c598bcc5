"""How the device's wrench answers to the jaw's motion, linearised: its motors' servos, and the governor's brake.

An ``answer`` (6, n) says by how much the wrench at the mouthpiece falls as the jaw's state grows by a unit: force (N)
and moment (N m) in body axes. ``by_place`` (n / 2, 3) is what the reference point moves by with each coordinate, and
the axes about which the last three turn the body; both in body axes.
"""

from __future__ import annotations

from jawenv.compiled import njit
from jawenv.device.device import N_MOTORS
from jawenv.device.motors import BRAKE_ONSET, YIELD_FORCE
from jawenv.mechanics.vec3 import add, apply_transposed, cross, dot, norm, row3, scale


@njit
def add_servos(device, mouthpiece, by_place, body_to_head, answer):
    """Add to ``answer`` what the position servos of trajectory control do.

    The thrust of each motor falls by stiffness times the advance of its point and by damping times its speed; caps are
    left out.

    Args:
        device: A record of dtype ``DEVICE``.
        mouthpiece: Its place (m, body axes).
        by_place: As above.
        body_to_head: Rotation from body to head axes.
        answer: (6, n).
    """
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
                answer[k, c] += axis[k] * device.servo_stiffness * advance
                answer[3 + k, c] += moment[k] * device.servo_stiffness * advance
                answer[k, half + c] += axis[k] * device.servo_damping * speed
                answer[3 + k, half + c] += moment[k] * device.servo_damping * speed


@njit
def add_brake(device, mouthpiece, by_place, speeds, reading, answer):
    """Add to ``answer`` what the governor's brake does; False, and nothing added, where it does not work.

    It pushes against the mouthpiece's velocity by so much per m/s above its onset, and the motors yield to it.

    Args:
        device: A record of dtype ``DEVICE``.
        mouthpiece: Its place (m, body axes).
        by_place: As above.
        speeds: (n / 2,) velocities of the coordinates that slide, angular velocity (body axes).
        reading: (6,) the load cell's, from which the motors' part follows.
        answer: (6, n).
    """
    half = by_place.shape[0]
    first = half - 3
    velocity = cross((speeds[first], speeds[first + 1], speeds[first + 2]), mouthpiece)
    for c in range(first):
        velocity = add(velocity, scale(speeds[c], row3(by_place, c)))
    speed = norm(velocity)
    excess = speed - BRAKE_ONSET
    if not excess > 0.0 or device.brake == 0.0:
        return False
    along = scale(1.0 / speed, velocity)
    pressed = device.brake * excess
    share = 1.0 - pressed / YIELD_FORCE
    for c in range(half):
        unit = row3(by_place, c)
        if c >= first:
            axis = (1.0 if c == first else 0.0, 1.0 if c == first + 1 else 0.0, 1.0 if c == first + 2 else 0.0)
            unit = cross(axis, mouthpiece)
        faster = dot(along, unit)
        for k in range(3):
            across = unit[k] - faster * along[k]
            answer[k, half + c] += device.brake * (faster * along[k] + across * excess / speed)
            if share > 0.0:
                yielded = device.brake * faster / (YIELD_FORCE * share)
                answer[k, half + c] += yielded * (reading[k] + pressed * along[k])
                answer[3 + k, half + c] += yielded * reading[3 + k]
    return True
