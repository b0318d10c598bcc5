"""The two control laws that turn targets into actions, one for each control mode of the device.

Positions are the columns (opening in mm above rest, side in mm, roll in rad); the fore-aft channel is a force. Both
laws see only the observation. Motors in order: vertical left and right, horizontal left and right; roll and yaw come
from the difference of two motors.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.protocol import Array
from jawenv.anatomy import default_mandible
from jawenv.device.device import Device

_DEVICE = Device()
_VERTICAL_ARM, _HORIZONTAL_ARM = _DEVICE.vertical_arm_mm, _DEVICE.horizontal_arm_mm
_MOUTHPIECE_MM = 1e3 * np.asarray(default_mandible().mouthpiece_m)


class Wanted(NamedTuple):
    """Targets in physical units.

    Attributes:
        place: (N, 3) opening (mm above rest), side (mm, + left), roll (rad from rest).
        rate: (N, 3) their rates per second.
        force_N: (N,) fore-aft force, + forward.
    """

    place: Array
    rate: Array
    force_N: Array


class Felt(NamedTuple):
    """What is observed: place and force as in `Wanted`; pitch in rad, opened as a share of the range."""

    place: Array
    force_N: Array
    down_N: Array
    pitch: Array
    opened: Array


def _motors(down: Array, forward: Array, roll: Array, yaw: Array) -> Array:
    """Four motors (N, 4): common downward and forward parts, and what the right one has more than the left."""
    return np.stack([down - roll, down + roll, forward - yaw, forward + yaw], axis=-1)


@dataclass(frozen=True)
class TrajectoryLaw:
    """Rates of the motors' targets: the target's own rate and a correction, and an admittance for the force.

    Attributes:
        correction: of a position error, 1/s.
        admittance: rate per error of the fore-aft force, mm/s/N. With a zero target the horizontal motors follow
            the jaw; that it swings back as it opens is fed forward.
        side_lever_mm: side motion of the incisors per angle that the horizontal motors turn, for feeding the target's
            rate forward. Less than the 91 mm between condyles and incisors, as the condyles shift the other way and
            the servo yields.
        fastest: largest rate asked for in any direction, mm/s: below the soft limit of speed.
    """

    correction: tuple[float, float, float] = (3.0, 3.0, 3.0)
    side_lever_mm: float = 40.0
    admittance: float = 8.0
    fastest: float = 30.0

    def act(self, wanted: Wanted, felt: Felt, integral: Array, dt: float) -> tuple[Array, Array]:
        """Action (N, 4); the integral (N, 3) is not used and returned as it is."""
        rate = wanted.rate + self.correction * (wanted.place - felt.place)
        down, side = np.clip(rate[:, :2], -self.fastest, self.fastest).T
        forward = self.admittance * (wanted.force_N - felt.force_N) - _height_over_lever(felt.pitch) * down
        forward = np.clip(forward, -self.fastest, self.fastest)
        roll = _VERTICAL_ARM * rate[:, 2]
        yaw = side * _HORIZONTAL_ARM / self.side_lever_mm
        return np.clip(_motors(down, forward, roll, yaw) / _DEVICE.max_rate_mm_s, -1.0, 1.0), integral


@dataclass(frozen=True)
class ForceLaw:
    """Thrusts: what a typical jaw would need for the target, and an integral law on the error for the rest.

    The jaw is overdamped, so an integral alone is stable and smooth; answering its place or speed at once would only
    add to the shaking by the unmodelled force. The fore-aft force is fed straight through; it also closes the jaw, by
    its height below the condyles over their distance, and that much is added to the vertical thrust.

    Attributes:
        stiffness: of a typical closed jaw: N/mm for opening, N m/mm for side and N m/rad for roll.
        stiffening: what full opening adds to it.
        integral: gain as a share of the stiffness, 1/s; more for a jaw that takes more force to open.
        largest: what the integral may reach: N, N m, N m.
        holds_roll: false leaves roll free, as equal thrusts of the vertical motors do.
    """

    stiffness: tuple[float, float, float] = (0.12, 0.009, 2.0)
    stiffening: tuple[float, float, float] = (0.0, 0.012, 2.0)
    integral: tuple[float, float, float] = (5.0, 5.0, 3.0)
    largest: tuple[float, float, float] = (12.0, 0.3, 0.2)
    holds_roll: bool = False

    def act(self, wanted: Wanted, felt: Felt, integral: Array, dt: float) -> tuple[Array, Array]:
        """Action (N, 4) and the new integral (N, 3) in N, N m and N m."""
        stiffness = self.stiffness + np.multiply.outer(np.clip(felt.opened, 0.0, 1.0), self.stiffening)
        error = wanted.place - felt.place
        integral = integral + self._stiffer(felt)[:, None] * stiffness * self.integral * error * dt
        integral = np.clip(integral, np.negative(self.largest), self.largest)
        down, yaw, roll = (stiffness * wanted.place + integral).T
        roll = roll * self.holds_roll
        down = down + wanted.force_N * _height_over_lever(felt.pitch)
        forward = wanted.force_N / 2.0
        thrust = _motors(down / 2.0, forward, 1e3 * roll / (2.0 * _VERTICAL_ARM), 1e3 * yaw / (2.0 * _HORIZONTAL_ARM))
        return np.clip(thrust / _DEVICE.full_scale_N, -1.0, 1.0), integral

    def _stiffer(self, felt: Felt) -> Array:
        """How much stiffer than typical the jaw is (N,), 1 to 5, by the force that holds it open.

        A typical jaw takes twice its stiffness times the opening, as it must be lifted off the teeth first.
        """
        typical = 2.0 * self.stiffness[0] * np.maximum(felt.place[:, 0], 5.0)
        return np.clip(felt.down_N / typical, 1.0, 5.0)


def _height_over_lever(pitch: Array) -> Array:
    """How far the mouthpiece is below the condyles, over how far it is before them."""
    x, _, z = _MOUTHPIECE_MM
    below: Array = x * np.sin(pitch) - z * np.cos(pitch)
    ahead: Array = x * np.cos(pitch) + z * np.sin(pitch)
    return below / ahead
