"""The two control laws that turn targets into actions: rates for servos, thrusts for motors.

Places are (opening in mm above rest, side in mm, roll in rad); the fore-aft channel is a force. Motors in order:
vertical left and right, horizontal left and right; roll and yaw come from the difference of two motors.
"""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

from jawenv.anatomy import default_mandible
from jawenv.device.device import DeviceRecord
from jawenv.kernels.compiled import njit

_MOUTHPIECE_X, _MOUTHPIECE_Z = 1e3 * default_mandible().mouthpiece_m[0], 1e3 * default_mandible().mouthpiece_m[2]

# Rates of the motors' targets: the target's own rate and a correction, and an admittance for the fore-aft force.
CORRECTION = 3.0  # of a position error, 1/s
# Side motion of the incisors (mm) per angle that the horizontal motors turn, for feeding the target's rate forward.
# Less than the 91 mm between condyles and incisors, as the condyles shift the other way and the servo yields.
SIDE_LEVER = 40.0
# Rate per error of the fore-aft force, mm/s/N. With a zero target the horizontal motors follow the jaw; that it swings
# back as it opens is fed forward.
ADMITTANCE = 8.0
FASTEST = 30.0  # mm/s asked for in any direction, at most: below the soft limit of speed

# Thrusts: what a typical jaw would need for the target, and an integral law on the error for the rest. The jaw is
# overdamped, so an integral alone is stable and smooth; answering its place or speed at once would only add to the
# shaking by the unmodelled force. The fore-aft force is fed straight through; it also closes the jaw, by its height
# below the condyles over their distance, and that much is added to the vertical thrust.
STIFFNESS = (0.12, 0.009, 2.0)  # of a typical closed jaw: N/mm for opening, N m/mm for side, N m/rad for roll
STIFFENING = (0.0, 0.012, 2.0)  # what full opening adds to it
INTEGRAL = (5.0, 5.0, 3.0)  # gain as a share of the stiffness, 1/s; more for a jaw that takes more force to open
LARGEST_INTEGRAL = (24.0, 0.9, 0.6)  # N, N m, N m


class Felt(NamedTuple):
    """The sensed motion and forces.

    Opening and side in mm, roll from rest and pitch in rad, forces forward and down in N, and how far the jaw is open,
    as a share of its painless range.
    """

    opening: float
    side: float
    roll: float
    pitch: float
    forward: float
    down: float
    opened: float


class Wanted(NamedTuple):
    """Targets in the same units, and the rates of the first three per second."""

    opening: float
    side: float
    roll: float
    forward: float
    opening_rate: float
    side_rate: float
    roll_rate: float


@njit
def _arms_mm(device: DeviceRecord):
    """Distances from the midline at which the vertical and the horizontal motors push, mm."""
    return 1e3 * abs(device.point[0, 1]), 1e3 * abs(device.point[2, 1])


@njit
def _height_over_lever(pitch):
    """Height of the mouthpiece below the condyles, divided by its distance before them."""
    below = _MOUTHPIECE_X * sin(pitch) - _MOUTHPIECE_Z * cos(pitch)
    return below / (_MOUTHPIECE_X * cos(pitch) + _MOUTHPIECE_Z * sin(pitch))


@njit
def within(value, largest):
    """``value`` limited to -``largest`` and ``largest``."""
    return min(max(value, -largest), largest)


@njit
def _set_motors(action, down, forward, roll, yaw, full):
    """Four motors from common downward and forward parts and what right has more than left, over ``full``."""
    action[0], action[1] = within((down - roll) / full, 1.0), within((down + roll) / full, 1.0)
    action[2], action[3] = within((forward - yaw) / full, 1.0), within((forward + yaw) / full, 1.0)


@njit
def servo_rates(device: DeviceRecord, targets: Wanted, felt: Felt, action):
    """Rates of the motors' targets, as shares of the largest, into ``action`` (4)."""
    vertical_arm, horizontal_arm = _arms_mm(device)
    down = within(targets.opening_rate + CORRECTION * (targets.opening - felt.opening), FASTEST)
    side = within(targets.side_rate + CORRECTION * (targets.side - felt.side), FASTEST)
    roll = vertical_arm * (targets.roll_rate + CORRECTION * (targets.roll - felt.roll))
    forward = ADMITTANCE * (targets.forward - felt.forward) - _height_over_lever(felt.pitch) * down
    yaw = side * horizontal_arm / SIDE_LEVER
    _set_motors(action, down, within(forward, FASTEST), roll, yaw, 1e3 * device.max_rate)


@njit
def thrusts(device: DeviceRecord, targets: Wanted, felt: Felt, holds_roll, integral, dt, action):
    """Thrusts of the motors, as shares of full scale, into ``action`` (4); changes ``integral`` (3)."""
    opened = min(max(felt.opened, 0.0), 1.0)
    # How much stiffer than typical: a typical jaw takes twice its stiffness times the opening, as it must be lifted off
    # the teeth first.
    stiffer = min(max(felt.down / (2.0 * STIFFNESS[0] * max(felt.opening, 5.0)), 1.0), 10.0)
    position = (targets.opening, targets.side, targets.roll)
    error = (targets.opening - felt.opening, targets.side - felt.side, targets.roll - felt.roll)
    push = (0.0, 0.0, 0.0)
    for k in range(3):
        stiffness = STIFFNESS[k] + opened * STIFFENING[k]
        grown = integral[k] + stiffer * stiffness * INTEGRAL[k] * error[k] * dt
        integral[k] = within(grown, LARGEST_INTEGRAL[k])
        value = stiffness * position[k] + integral[k]
        push = (value if k == 0 else push[0], value if k == 1 else push[1], value if k == 2 else push[2])
    down = push[0] + targets.forward * _height_over_lever(felt.pitch)
    vertical_arm, horizontal_arm = _arms_mm(device)
    yaw = 1e3 * push[1] / (2.0 * horizontal_arm)
    roll = 1e3 * push[2] / (2.0 * vertical_arm) if holds_roll else 0.0
    _set_motors(action, down / 2.0, targets.forward / 2.0, roll, yaw, device.full_scale)
