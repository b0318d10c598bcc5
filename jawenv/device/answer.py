"""How the device's wrench answers to the jaw's motion, linearised: its motors' servos, and the governor's brake.

An ``answer`` (6, n) says by how much the wrench at the mouthpiece falls as the jaw's state grows by a unit: force (N)
and moment (N m) in body axes. ``by_place`` (n / 2, 3) is what the reference point moves by with each coordinate, and
the axes about which the last three turn the body; both in body axes.
"""

from __future__ import annotations

from math import erfc, exp, pi, sqrt

from jawenv.compiled import njit
from jawenv.device.device import N_MOTORS
from jawenv.device.motors import BRAKE_ONSET, YIELD_FORCE
from jawenv.mechanics.vec3 import add, apply_transposed, cross, dot, norm, row3, scale

NEVER = 1e-3  # chance to be braked, below which the brake is left out


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
def add_brake(device, mouthpiece, by_place, speeds, speeds_cov, reading, answer, spare):
    """Add to ``answer`` what the governor's brake does; False, and nothing added, where it hardly ever works.

    It pushes against the mouthpiece's velocity by so much per m/s above its onset, and the motors yield to it.

    Args:
        device: A record of dtype ``DEVICE``.
        mouthpiece: Its place (m, body axes).
        by_place: As above.
        speeds: (n / 2,) velocities of the coordinates that slide, angular velocity (body axes).
        speeds_cov: (n / 2, n / 2) their covariance.
        reading: (6,) the load cell's, from which the motors' part follows.
        answer: (6, n).
        spare: (n / 2 or more,) working memory.
    """
    half = by_place.shape[0]
    velocity = (0.0, 0.0, 0.0)
    for c in range(half):
        velocity = add(velocity, scale(speeds[c], unit_velocity(by_place, mouthpiece, c)))
    speed = norm(velocity)
    if device.brake == 0.0 or not speed > 0.0:
        return False
    along = scale(1.0 / speed, velocity)
    for c in range(half):
        spare[c] = dot(along, unit_velocity(by_place, mouthpiece, c))
    variance = 0.0
    for i in range(half):
        for j in range(half):
            variance += spare[i] * spare[j] * speeds_cov[i, j]
    chance, excess = exceed(speed - BRAKE_ONSET, variance)
    if chance < NEVER:
        return False
    pressed = device.brake * excess
    share = 1.0 - pressed / YIELD_FORCE
    for c in range(half):
        unit, faster = unit_velocity(by_place, mouthpiece, c), spare[c]
        for k in range(3):
            across = unit[k] - faster * along[k]
            answer[k, half + c] += device.brake * (chance * faster * along[k] + across * excess / speed)
            if share > 0.0:
                yielded = device.brake * chance * faster / (YIELD_FORCE * share)
                answer[k, half + c] += yielded * (reading[k] + pressed * along[k])
                answer[3 + k, half + c] += yielded * reading[3 + k]
    return True


@njit
def unit_velocity(by_place, mouthpiece, c):
    """Velocity of the mouthpiece (body axes) where the coordinate c has the speed 1."""
    turn = c - by_place.shape[0] + 3
    if turn < 0:
        return row3(by_place, c)
    return cross((1.0 if turn == 0 else 0.0, 1.0 if turn == 1 else 0.0, 1.0 if turn == 2 else 0.0), mouthpiece)


@njit
def exceed(mean, variance):
    """Chance that a normal variable is above zero, and the mean of what it is above."""
    if not variance > 0.0:
        return (1.0, mean) if mean > 0.0 else (0.0, 0.0)
    sd = sqrt(variance)
    z = mean / sd
    chance = 0.5 * erfc(-z / sqrt(2.0))
    return chance, mean * chance + sd * exp(-0.5 * z * z) / sqrt(2.0 * pi)
