"""The device that drives and feels the jaw: four linear motors, their linkage, its load cell and encoders.

Motors in order: vertical left, vertical right (open and roll), horizontal left, horizontal right (protrude and yaw).
They push along fixed directions of the head on points of the mouthpiece. All forces and speeds of this file are at the
mouthpiece; the linkage multiplies the motor's thrust by ``lever`` and divides its speed by it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from jawenv.base.files import instance_of
from jawenv.base.numeric_fields import NumericFields, number
from jawenv.kernels.records import Array, record_dtype, record_zeros

TICK = 0.01  # s: sensors, filter and motor commands run at 100 Hz
LAW_TICKS = 5  # from one command of the law of targets to the next: 20 Hz
N_MOTORS = 4
# Gain, Coulomb friction (N), viscous friction (N s/m), and a turn of the direction (3, rad, head axes), of each motor
# where no load cell reads the force (``force_sensor``).
N_ERRORS = 6
MOTOR_NAMES = ("vertical_left", "vertical_right", "horizontal_left", "horizontal_right")


class DeviceRecord:
    """The device, SI units."""

    point: Annotated[Array, N_MOTORS, 3]  # from the mouthpiece's point, body axes
    direction: Annotated[Array, N_MOTORS, 3]  # of positive thrust, head axes
    full_scale: float
    thrust_continuous: float
    thrust_peak: float
    no_load_speed: float
    thermal_time: float
    force_cap: float
    slew: float
    lag: float
    max_rate: float
    servo_stiffness: float
    servo_damping: float
    stop_stiffness: float
    stop_damping: float
    brake: float
    unmodelled_force: float
    unmodelled_moment: float
    unmodelled_time: float
    cell_force: float
    cell_moment: float
    cell_gain: float
    encoder_position: float
    encoder_angle: float
    encoder_velocity: float
    encoder_rate: float


DEVICE = record_dtype(DeviceRecord)


class Linkage:
    """Directions of the device's motors, and their points on the mouthpiece."""

    # The directions first: a record that began as the device's does would be taken for a part of it.
    direction: Annotated[Array, N_MOTORS, 3]
    point: Annotated[Array, N_MOTORS, 3]


@dataclass(frozen=True)
class Device(NumericFields):
    """Numbers of the device. Grade M: a maker's sheet or a measurement, A: assumption, G: guess."""

    vertical_arm_mm: float = number(25.0, 1000.0, "mm", zero=False)
    """Half the distance between the vertical motors' points on the mouthpiece (G)."""
    horizontal_arm_mm: float = number(30.0, 1000.0, "mm", zero=False)
    """The same for the horizontal motors (G)."""
    lever: float = number(0.25, 10.0, "1", zero=False)
    """Force at the mouthpiece per thrust of the motor: 3 cm over 12 cm (Young 2016, section 3.3; A)."""
    full_scale_N: float = number(12.0, 600.0, "N", zero=False)
    """Force at the mouthpiece that the action 1 commands of one motor (A)."""
    motor_continuous_N: float = number(150.0, 15000.0, "N", zero=False)
    """Thrust that the motor holds for ever (150 N, KocoMotion 2015, in Young 2016; M)."""
    motor_peak_N: float = number(230.0, 23000.0, "N", zero=False)
    """Thrust that it gives while cool (230 N, same source; M)."""
    motor_no_load_mm_s: float = number(20.0, 2000.0, "mm/s", zero=False)
    """Speed of the motor at which its thrust has fallen to zero (G: 8-20 mm/s)."""
    thermal_s: float = number(10.0, 1000.0, "s", zero=False, record="thermal_time")
    """Time constant of the motor's heat, proportional to thrust squared (G)."""
    force_cap_N: float = number(40.0, 4000.0, "N", zero=False)
    """Largest force of the device on the mouthpiece, whatever the motors could do (Young 2016, 3.3; G)."""
    slew_N_s: float = number(24.0, 100000.0, "N/s", zero=False)
    """Largest rate of change of one motor's commanded force at the mouthpiece (G)."""
    lag_s: float = number(0.02, 2.0, "s", zero=False)
    """Time constant with which thrust, or rate in trajectory control, follows its command (G)."""
    max_rate_mm_s: float = number(40.0, 4000.0, "mm/s", zero=False)
    """Target rate that the action 1 commands of one motor in trajectory control (G)."""
    servo_stiffness_N_m: float = number(1000.0, 60000.0, "N/m", zero=False)
    """Stiffness of one motor's position servo at the mouthpiece (G)."""
    servo_damping_N_s_m: float = number(10.0, 800.0, "N s/m", zero=False)
    """Its damping (G)."""
    stop_stiffness_N_m: float = number(5000.0, 500000.0, "N/m", zero=False)
    """Stiffness of the governor's end stops in the linkage (G)."""
    stop_damping_N_s_m: float = number(10.0, 1000.0, "N s/m", zero=False)
    """Their damping while pressed (G)."""
    brake_N_s_m: float = number(90.0, 100.0, "N s/m")
    """The governor's speed brake (G). From 300 on a jaw of 0.2 kg stops within a step of the simulation."""
    unmodelled_force_N: float = number(0.1, 10.0, "N")
    """Sd of each component of the force that no model explains, anew every 10 ms (G)."""
    unmodelled_moment_N_m: float = number(0.003, 0.3, "N m")
    """The same for its moment (G)."""
    unmodelled_time_s: float = number(0.0, 100.0, "s")
    """Time constant of its memory (an Ornstein-Uhlenbeck process of these sds); 0 for none (G: what tone and a
    breathing, swallowing patient do lasts for tenths of a second to seconds).
    """
    cell_force_N: float = number(0.04, 4.0, "N")
    """Noise of one sample of the load cell, three per 10 ms (G: 0.02-0.2 N)."""
    cell_moment_N_m: float = number(0.0008, 0.08, "N m")
    """The same for its moments (G)."""
    cell_gain: float = number(0.01, 0.5, "1")
    """Sd of the load cell's gain error, one value for a whole episode (G: 1 %)."""
    motor_table_gain: float = number(0.07, 0.2, "1")
    """Sd of the error of each motor's force-velocity table, relative (G: 5-10 %). This and what follows up to
    ``strap_pretension_N`` matters where ``force_sensor`` says so, in place of the load cell's.
    """
    motor_table_N: float = number(0.05, 4.0, "N")
    """Noise of one reading of each motor's force, three per 10 ms (G)."""
    motor_coulomb_N: float = number(0.3, 10.0, "N")
    """Sd of the level of each motor's Coulomb friction beyond what the table has, at the mouthpiece (G: a few per
    cent of what a motor gives there).
    """
    motor_viscous_N_s_m: float = number(2.0, 1000.0, "N s/m")
    """The same for viscous friction (G)."""
    strap_gain: float = number(0.02, 0.2, "1")
    """Sd of the gain error of each strap's sensor (G: 1-3 %)."""
    strap_N: float = number(0.05, 4.0, "N")
    """Noise of one reading of each strap's tension (G)."""
    strap_direction_deg: float = number(2.0, 10.0, "deg")
    """Sd of each of the two angles by which each strap's direction is off (G: 1-3 degrees)."""
    strap_pretension_N: float = number(10.0, 1000.0, "N")
    """Tension of each strap while its motor does nothing; 0 for straps that only pull (G)."""
    encoder_position_mm: float = number(0.1, 10.0, "mm")
    """Noise of the mouthpiece position (G: 0.05-0.3 mm)."""
    encoder_angle_deg: float = number(0.1, 180.0, "deg")
    """Noise of the mouthpiece angles (M: optical tracker 0.126 deg, Mueller 2025)."""
    encoder_velocity_mm_s: float = number(1.0, 100.0, "mm/s")
    """Noise of the mouthpiece velocity (G: 0.5-3 mm/s)."""
    encoder_rate_rad_s: float = number(0.02, 2.0, "rad/s")
    """Noise of the angular velocity (G)."""

    def records(self) -> NDArray[np.void]:
        """The device as an array of one record of dtype ``DEVICE``, as the kernels read it, in SI units."""
        records, si = record_zeros(1, DEVICE), self.in_si()
        self.fill(records)
        vertical, horizontal = si["vertical_arm"], si["horizontal_arm"]
        records["point"] = [(0, vertical, 0), (0, -vertical, 0), (0, horizontal, 0), (0, -horizontal, 0)]
        records["direction"] = [(0, 0, -1), (0, 0, -1), (1, 0, 0), (1, 0, 0)]
        records["thrust_continuous"] = si["motor_continuous"] * si["lever"]
        records["thrust_peak"] = si["motor_peak"] * si["lever"]
        records["no_load_speed"] = si["motor_no_load"] / si["lever"]
        return records


def device_of(device: object) -> Device:
    """The device that is given as itself, as a mapping of fields or as the path of a file; None is the default one."""
    return Device() if device is None else instance_of(Device, device, "device")
