"""Three ways to know the device's force (Young 2016, section 3.4), and the errors of those without a load cell.

``cell``: a load cell at the mouthpiece. ``motors``: the motors' force-velocity table, which is off by a share for each
motor, with friction of unknown level in each (Coulomb's and viscous), beside what the table takes off for it.
``straps``: tensile sensors in the straps, one for each motor, whose direction is known only within degrees. Straps
cannot push: they are pretensioned, and slack where the pull is used up.

The last two give four forces along believed directions, and the filter gets the wrench that these make. The sensors
are between linkage and mouthpiece: what stops and brake do is in what they read, and what of it is no sum of the four
forces, sideways above all, is read without these errors. What acts is then

    w = r + sum_i (e_i, p_i x e_i),    e_i = a_i (g_i f_i - c_i z_i - d_i v_i) + t_i f_i,

with r what is read, f_i its forces, v_i the rates of the motors, a_i their directions (unit vectors of the head), p_i
their points, and g_i, c_i, d_i and t_i the errors. z_i is the share of Coulomb's friction that acts, -1 to 1: it
changes sign over a distance of presliding (Dahl 1968, Aerospace Corporation TOR-0158), not at once as v_i does.
"""

from __future__ import annotations

from math import exp
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from jawenv.device.device import N_ERRORS, N_MOTORS, Device, DeviceRecord, Linkage
from jawenv.device.motors import ON_PATH, motor_point, mouthpiece_motion
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply_transposed, cross, dot, row3, scale
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import rotation, split

ForceSensor = Literal["cell", "motors", "straps"]
FORCE_SENSORS = get_args(ForceSensor)

N_SDS = 5  # of the errors of a motor: the turn of the direction is about two axes
UNKNOWN_SHARE = 0.3  # sd; as noise that is new in each tick it weighs about what errors of 0.07 do that last 0.1 s (D)
PRESLIDING = 0.5e-3  # m at the mouthpiece, 0.1 mm at the motor, over which friction comes to its level (G)

Array = NDArray[np.float64]


def sds_of_sensor(sensor: ForceSensor, device: Device) -> Array | None:
    """(5,) sds of a motor's errors: gain, both frictions (SI), direction about two axes (rad). None for the cell."""
    if sensor == "cell":
        return None
    si = device.in_si()
    if sensor == "motors":
        return np.array([device.motor_table_gain, si["motor_coulomb"], si["motor_viscous"], 0.0, 0.0])
    turn = si["strap_direction"]
    return np.array([device.strap_gain, 0.0, 0.0, turn, turn])


def device_with_sensor(sensor: ForceSensor, device: Device) -> NDArray[np.void]:
    """``Device.records`` where the load cell's noise is that of the wrench that the sensors' readings make."""
    records = device.records()
    if sensor != "cell":
        noise = device.motor_table_N if sensor == "motors" else device.strap_N
        records["cell_force"] = np.sqrt(2.0) * noise
        records["cell_moment"] = np.sqrt(2.0) * noise * _arm(records)
        records["cell_gain"] = 0.0
    return records


def friction_noise(sensor: ForceSensor, device: Device) -> tuple[float, float]:
    """Sds (N, N m) of the wrench, new in each tick, that stands for what the filter has wrong of friction's share.

    The share depends on the path in each direction, which the encoders' noise blurs.
    """
    if sensor != "motors":
        return 0.0, 0.0
    force = np.sqrt(2.0) * UNKNOWN_SHARE * device.motor_coulomb_N
    return force, force * _arm(device.records())


def _arm(records: NDArray[np.void]) -> float:
    """Mean distance (m) of the motors' points from the midline."""
    return 0.5 * float(records["point"][0, 0, 1] + records["point"][0, 2, 1])


def slack_force(sensor: ForceSensor, device: Device) -> float:
    """Force along a motor's direction (N) below which its strap is slack and the wrench is not read."""
    return -device.strap_pretension_N if sensor == "straps" else -np.inf


def motor_errors(sds: Array, values: Array, device: Any) -> Array:
    """(4, ``N_ERRORS``) errors of the motors in SI units, from ``values`` (4, 5) in sds and a record of ``DEVICE``."""
    errors = np.zeros((N_MOTORS, N_ERRORS))
    errors[:, :3] = sds[:3] * values[:, :3]
    for i, axis in enumerate(device["direction"]):
        along = int(np.abs(axis).argmax())
        across = [np.eye(3)[(along + 1) % 3], np.eye(3)[(along + 2) % 3]]
        errors[i, 3:] = sds[3] * values[i, 3] * across[0] + sds[4] * values[i, 4] * across[1]
    return errors


@njit
def motor_forces(linkage: DeviceRecord | Linkage, body_to_head, wrench):
    """The four forces along the motors' directions that make a wrench (six numbers, body axes) best.

    ``linkage`` has ``point`` and ``direction`` of the device: motors in pairs, left and right, on the body's y axis.
    """
    down = apply_transposed(body_to_head, row3(linkage.direction, 0))
    ahead = apply_transposed(body_to_head, row3(linkage.direction, 2))
    force, moment = (wrench[0], wrench[1], wrench[2]), (wrench[3], wrench[4], wrench[5])
    # Moments of what left has more than right, per N and m: about x and z.
    by_down, by_ahead = (down[2], 0.0, -down[0]), (ahead[2], 0.0, -ahead[0])
    first, both, last = dot(by_down, by_down), dot(by_down, by_ahead), dot(by_ahead, by_ahead)
    one, other, determinant = dot(by_down, moment), dot(by_ahead, moment), first * last - both * both
    down_sum, ahead_sum = dot(force, down), dot(force, ahead)
    down_more = (last * one - both * other) / determinant / linkage.point[0, 1]
    ahead_more = (first * other - both * one) / determinant / linkage.point[2, 1]
    return (
        0.5 * (down_sum + down_more),
        0.5 * (down_sum - down_more),
        0.5 * (ahead_sum + ahead_more),
        0.5 * (ahead_sum - ahead_more),
    )


@njit
def motor_rates(linkage: DeviceRecord | Linkage, jaw: Jaw, q, u, lift=ON_PATH):
    """Rates (m/s) of the four motors' points along their directions; ``lift`` as ``mouthpiece_motion`` takes it."""
    body_to_head = rotation(q)
    point, velocity = mouthpiece_motion(jaw, q, u, lift, body_to_head)
    omega = (u[2], u[3], u[4])
    _, _, _, one = motor_point(linkage, jaw, 0, body_to_head, point, velocity, omega)
    _, _, _, two = motor_point(linkage, jaw, 1, body_to_head, point, velocity, omega)
    _, _, _, three = motor_point(linkage, jaw, 2, body_to_head, point, velocity, omega)
    _, _, _, four = motor_point(linkage, jaw, 3, body_to_head, point, velocity, omega)
    return one, two, three, four


@njit
def slid(share, moved):
    """The ``share`` of Coulomb's friction (-1 to 1) after the motor has ``moved`` (m) one way."""
    towards = 1.0 if moved > 0.0 else -1.0
    return towards + (share - towards) * exp(-abs(moved) / PRESLIDING)


@njit
def moving_motors(shares, first, last, part, dt):
    """Shares of friction and rates of the motors a ``part`` (0 to 1) into a tick.

    ``shares`` is that of its start, ``first`` and ``last`` are the rates at start and end; four each.
    """
    one, two = first[0] + part * (last[0] - first[0]), first[1] + part * (last[1] - first[1])
    three, four = first[2] + part * (last[2] - first[2]), first[3] + part * (last[3] - first[3])
    half = 0.5 * part * dt
    slipped = (
        slid(shares[0], half * (first[0] + one)),
        slid(shares[1], half * (first[1] + two)),
        slid(shares[2], half * (first[2] + three)),
        slid(shares[3], half * (first[3] + four)),
    )
    return slipped, (one, two, three, four)


@njit
def error_wrench(linkage: DeviceRecord | Linkage, errors, motors, body_to_head):
    """The wrench beyond the readings, force and moment (body axes), for ``errors`` (4, 6).

    ``motors`` is (forces, shares of Coulomb's friction, rates), of four each.
    """
    forces, shares, rates = motors
    force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(N_MOTORS):
        friction = errors[i, 1] * shares[i] + errors[i, 2] * rates[i]
        pull = scale(errors[i, 0] * forces[i] - friction, row3(linkage.direction, i))
        pull = add(pull, scale(forces[i], (errors[i, 3], errors[i, 4], errors[i, 5])))
        in_body = apply_transposed(body_to_head, pull)
        force = add(force, in_body)
        moment = add(moment, cross(row3(linkage.point, i), in_body))
    return force, moment


@njit
def _read_one(errors, i, force, share, rate):
    """The reading of motor i's sensor under ``force``."""
    return (force + errors[i, 1] * share + errors[i, 2] * rate) / (1.0 + errors[i, 0])


@njit
def read_forces(errors, forces, shares, rates):
    """The readings of the four sensors under the motors' ``forces``."""
    return (
        _read_one(errors, 0, forces[0], shares[0], rates[0]),
        _read_one(errors, 1, forces[1], shares[1], rates[1]),
        _read_one(errors, 2, forces[2], shares[2], rates[2]),
        _read_one(errors, 3, forces[3], shares[3], rates[3]),
    )


@njit
def read_force(device: DeviceRecord, jaw: Jaw, truth, dt, samples):
    """Make of true wrenches what the sensors read of them, in ``samples`` (3, 6), to which noise may have been added.

    ``truth`` is a world's, at the end of the tick: its ``friction_share`` is that of the tick before, and becomes this
    one's. A slack strap leaves the wrench unread.
    """
    errors, shares = truth.motor_errors, truth.friction_share
    q, u = split(truth.state)
    lift = truth.lift[0], truth.lift[1]
    body_to_head, rates, before = rotation(q), motor_rates(device, jaw, q, u, lift), truth.motor_rate
    for i in range(samples.shape[0]):
        acting = motor_forces(device, body_to_head, samples[i])
        if min(min(acting[0], acting[1]), min(acting[2], acting[3])) < truth.slack_below:
            samples[i, :] = np.nan
            continue
        now, rates_now = moving_motors(shares, before, rates, 0.5 * i, dt)
        forces = read_forces(errors, acting, now, rates_now)
        force, moment = error_wrench(device, errors, (forces, now, rates_now), body_to_head)
        for k in range(3):
            samples[i, k] -= force[k]
            samples[i, 3 + k] -= moment[k]
    after, _ = moving_motors(shares, before, rates, 1.0, dt)
    for i in range(N_MOTORS):
        shares[i], before[i] = after[i], rates[i]
