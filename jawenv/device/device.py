"""The device that drives and feels the jaw: four linear motors, their linkage, its load cell and encoders.

Motors in order: vertical left, vertical right (open and roll), horizontal left, horizontal right (protrude and yaw).
They push along fixed directions of the head on points of the mouthpiece. All forces and speeds of this file are at the
mouthpiece; the linkage multiplies the motor's thrust by ``lever`` and divides its speed by it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from jawenv.checks import real_number
from jawenv.errors import InputError, shown
from jawenv.files import instance_of, read_into
from jawenv.kernels.records import record_dtype, record_zeros

N_MOTORS = 4
MOTOR_NAMES = ("vertical_left", "vertical_right", "horizontal_left", "horizontal_right")

DEVICE = record_dtype(
    [
        ("point", "f8", (N_MOTORS, 3)),  # from the mouthpiece's point, body axes
        ("direction", "f8", (N_MOTORS, 3)),  # of positive thrust, head axes
        ("full_scale", "f8"),
        ("thrust_continuous", "f8"),
        ("thrust_peak", "f8"),
        ("no_load_speed", "f8"),
        ("thermal_time", "f8"),
        ("force_cap", "f8"),
        ("slew", "f8"),
        ("lag", "f8"),
        ("max_rate", "f8"),
        ("servo_stiffness", "f8"),
        ("servo_damping", "f8"),
        ("stop_stiffness", "f8"),
        ("stop_damping", "f8"),
        ("brake", "f8"),
        ("unmodelled_force", "f8"),
        ("unmodelled_moment", "f8"),
        ("cell_force", "f8"),
        ("cell_moment", "f8"),
        ("cell_gain", "f8"),
        ("encoder_position", "f8"),
        ("encoder_angle", "f8"),
        ("encoder_velocity", "f8"),
        ("encoder_rate", "f8"),
    ],
)


# Highest value of each field, mostly 100 times the default; and whether 0 is allowed, by which some formulas divide.
ALLOWED: Mapping[str, tuple[float, bool]] = MappingProxyType(
    {
        "vertical_arm_mm": (1000.0, False),
        "horizontal_arm_mm": (1000.0, False),
        "lever": (10.0, False),
        "full_scale_N": (600.0, False),
        "motor_continuous_N": (1.5e4, False),
        "motor_peak_N": (2.3e4, False),
        "motor_no_load_mm_s": (2000.0, False),
        "thermal_s": (1000.0, False),
        "force_cap_N": (4000.0, False),
        "slew_N_s": (1e5, False),
        "lag_s": (2.0, False),
        "max_rate_mm_s": (4000.0, False),
        "servo_stiffness_N_m": (6e4, False),
        "servo_damping_N_s_m": (800.0, False),
        "stop_stiffness_N_m": (5e5, False),
        "stop_damping_N_s_m": (1000.0, False),
        "brake_N_s_m": (3000.0, True),
        "unmodelled_force_N": (10.0, True),
        "unmodelled_moment_N_m": (0.3, True),
        "cell_force_N": (4.0, True),
        "cell_moment_N_m": (0.08, True),
        "cell_gain": (0.5, True),
        "encoder_position_mm": (10.0, False),
        "encoder_angle_deg": (180.0, False),
        "encoder_velocity_mm_s": (100.0, False),
        "encoder_rate_rad_s": (2.0, False),
    }
)


@dataclass(frozen=True)
class Device:
    """Numbers of the device. Grade M: a maker's sheet or a measurement, A: assumption, G: guess.

    Attributes:
        vertical_arm_mm: Half the distance between the vertical motors' points on the mouthpiece (G).
        horizontal_arm_mm: The same for the horizontal motors (G).
        lever: Force at the mouthpiece per thrust of the motor: 3 cm over 12 cm (Young 2016, section 3.3; A).
        full_scale_N: Force at the mouthpiece that the action 1 commands of one motor (A).
        motor_continuous_N: Thrust that the motor holds for ever (150 N, KocoMotion 2015, in Young 2016; M).
        motor_peak_N: Thrust that it gives while cool (230 N, same source; M).
        motor_no_load_mm_s: Speed of the motor at which its thrust has fallen to zero (G: 8-20 mm/s).
        thermal_s: Time constant of the motor's heat, proportional to thrust squared (G).
        force_cap_N: Largest force of the device on the mouthpiece, whatever the motors could do (Young 2016, 3.3; G).
        slew_N_s: Largest rate of change of one motor's commanded force at the mouthpiece (G).
        lag_s: Time constant with which thrust, or rate in trajectory control, follows its command (G).
        max_rate_mm_s: Target rate that the action 1 commands of one motor in trajectory control (G).
        servo_stiffness_N_m: Stiffness of one motor's position servo at the mouthpiece (G).
        servo_damping_N_s_m: Its damping (G).
        stop_stiffness_N_m: Stiffness of the governor's end stops in the linkage (G).
        stop_damping_N_s_m: Their damping while pressed (G).
        brake_N_s_m: The governor's speed brake (G).
        unmodelled_force_N: Sd of each component of the force that no model explains, anew every 10 ms (G).
        unmodelled_moment_N_m: The same for its moment (G).
        cell_force_N: Noise of one sample of the load cell, three per 10 ms (G: 0.02-0.2 N).
        cell_moment_N_m: The same for its moments (G).
        cell_gain: Sd of the load cell's gain error, one value for a whole episode (G: 1 %).
        encoder_position_mm: Noise of the mouthpiece position (G: 0.05-0.3 mm).
        encoder_angle_deg: Noise of the mouthpiece angles (M: optical tracker 0.126 deg, Mueller 2025).
        encoder_velocity_mm_s: Noise of the mouthpiece velocity (G: 0.5-3 mm/s).
        encoder_rate_rad_s: Noise of the angular velocity (G).
    """

    vertical_arm_mm: float = 25.0
    horizontal_arm_mm: float = 30.0
    lever: float = 0.25
    full_scale_N: float = 6.0
    motor_continuous_N: float = 150.0
    motor_peak_N: float = 230.0
    motor_no_load_mm_s: float = 20.0
    thermal_s: float = 10.0
    force_cap_N: float = 40.0
    slew_N_s: float = 12.0
    lag_s: float = 0.02
    max_rate_mm_s: float = 40.0
    servo_stiffness_N_m: float = 600.0
    servo_damping_N_s_m: float = 8.0
    stop_stiffness_N_m: float = 5000.0
    stop_damping_N_s_m: float = 10.0
    brake_N_s_m: float = 30.0
    unmodelled_force_N: float = 0.1
    unmodelled_moment_N_m: float = 0.003
    cell_force_N: float = 0.04
    cell_moment_N_m: float = 0.0008
    cell_gain: float = 0.01
    encoder_position_mm: float = 0.1
    encoder_angle_deg: float = 0.1
    encoder_velocity_mm_s: float = 1.0
    encoder_rate_rad_s: float = 0.02

    def __post_init__(self) -> None:
        """Check every field.

        Raises:
            InputError: a field is not a finite number, or out of its range (``ALLOWED``).
        """
        for name, (high, zero) in ALLOWED.items():
            value = getattr(self, name)
            number = real_number(value)
            if number is None or not 0.0 <= number <= high or (number == 0.0 and not zero):
                low = "0 or more" if zero else "more than 0"
                raise InputError(f"device.{name} is {shown(value)}; allowed: a finite number, {low}, at most {high:g}")
            object.__setattr__(self, name, number)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """A device with the fields that a mapping names; the others have their defaults.

        Raises:
            InputError: an unknown field, or a value that is not allowed.
        """
        names = [field.name for field in fields(cls)]
        for name in data:
            if name not in names:
                raise InputError(f"device.{name} is not a field of Device; allowed: {', '.join(names)}")
        return cls(**data)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """A device with the fields that a JSON, TOML or YAML file names.

        Raises:
            InputError: one line that names the file and what is wrong with it.
        """
        return read_into(path, cls.from_dict)

    def records(self) -> NDArray[np.void]:
        """The device as an array of one record of dtype ``DEVICE``, as the kernels read it, in SI units."""
        records = record_zeros(1, DEVICE)
        device = records[0]
        vertical, horizontal = self.vertical_arm_mm / 1e3, self.horizontal_arm_mm / 1e3
        device["point"] = [(0, vertical, 0), (0, -vertical, 0), (0, horizontal, 0), (0, -horizontal, 0)]
        device["direction"] = [(0, 0, -1), (0, 0, -1), (1, 0, 0), (1, 0, 0)]
        device["full_scale"] = self.full_scale_N
        device["thrust_continuous"] = self.motor_continuous_N * self.lever
        device["thrust_peak"] = self.motor_peak_N * self.lever
        device["no_load_speed"] = self.motor_no_load_mm_s / 1e3 / self.lever
        device["thermal_time"] = self.thermal_s
        device["force_cap"] = self.force_cap_N
        device["slew"] = self.slew_N_s
        device["lag"] = self.lag_s
        device["max_rate"] = self.max_rate_mm_s / 1e3
        device["servo_stiffness"] = self.servo_stiffness_N_m
        device["servo_damping"] = self.servo_damping_N_s_m
        device["stop_stiffness"] = self.stop_stiffness_N_m
        device["stop_damping"] = self.stop_damping_N_s_m
        device["brake"] = self.brake_N_s_m
        device["unmodelled_force"] = self.unmodelled_force_N
        device["unmodelled_moment"] = self.unmodelled_moment_N_m
        device["cell_force"] = self.cell_force_N
        device["cell_moment"] = self.cell_moment_N_m
        device["cell_gain"] = self.cell_gain
        device["encoder_position"] = self.encoder_position_mm / 1e3
        device["encoder_angle"] = np.radians(self.encoder_angle_deg)
        device["encoder_velocity"] = self.encoder_velocity_mm_s / 1e3
        device["encoder_rate"] = self.encoder_rate_rad_s
        return records


def device_of(device: object) -> Device:
    """The device that is given as itself, as a mapping of fields or as the path of a file; None is the default one.

    Raises:
        InputError: none of these, an unknown field, a value that is not allowed, or a file that cannot be read.
    """
    return Device() if device is None else instance_of(Device, device, "device")
