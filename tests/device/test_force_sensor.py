"""The force as motors and straps show it, by formulas of NumPy's, and what is made of it again."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jawenv.device.device import Device
from jawenv.device.force_sensor import (
    PRESLIDING,
    device_with_sensor,
    error_wrench,
    friction_noise,
    motor_errors,
    motor_forces,
    read_forces,
    sds_of_sensor,
    slid,
)
from jawenv.mechanics.kinematics import rotation

POSE = (2e-3, 1e-3, 0.2, 0.06, -0.05)
DEVICE = Device(vertical_arm_mm=20.0)


def wrench_of(forces, directions):
    """(6,) wrench in body axes of forces (4) along directions (4, 3) of the head on the motors' points."""
    to_body = np.array(rotation(POSE)).T
    pulls = np.array(forces)[:, None] * directions @ to_body.T
    moments = np.cross(DEVICE.records()[0]["point"], pulls)
    return np.concatenate([pulls.sum(axis=0), moments.sum(axis=0)])


def test_the_forces_of_four_motors_follow_from_their_wrench():
    record, forces = DEVICE.records()[0], (3.0, -1.0, 0.5, 2.0)
    found = motor_forces(record, rotation(POSE), tuple(wrench_of(forces, record["direction"])))
    np.testing.assert_allclose(found, forces, rtol=1e-12)


@pytest.mark.parametrize("sensor", ["motors", "straps"])
def test_what_is_read_and_its_error_make_what_acts(sensor, rng):
    """Gain and friction of the readings, and straps that pull another way than they are believed to."""
    record, sds = DEVICE.records()[0], sds_of_sensor(sensor, DEVICE)
    errors = motor_errors(sds, rng.normal(size=(4, 5)), record)
    forces, shares, rates = ([float(value) for value in rng.normal(size=4)] for _ in range(3))
    readings = read_forces(errors, tuple(forces), tuple(shares), tuple(rates))
    expected = (np.array(forces) + errors[:, 1] * shares + errors[:, 2] * rates) / (1.0 + errors[:, 0])
    np.testing.assert_allclose(readings, expected, rtol=1e-12)
    force, moment = error_wrench(record, errors, (readings, tuple(shares), tuple(rates)), rotation(POSE))
    acting = wrench_of(readings, record["direction"]) + np.concatenate([force, moment])
    along = wrench_of(forces, record["direction"]) + wrench_of(readings, errors[:, 3:])
    np.testing.assert_allclose(acting, along, atol=1e-12)
    assert (errors[:, 3:].any() == (sensor == "straps")) and (errors[:, 1:3].any() == (sensor == "motors"))
    assert np.abs(np.sum(errors[:, 3:] * record["direction"], axis=1)).max() == 0.0, "across the strap"


def test_friction_changes_sign_as_dahl_has_it():
    """His equation of the share z over the way x: dz/dx = (1 - z sign(v)) / presliding, backwards and forwards."""
    for start, moved in ((0.8, -0.7e-3), (-0.5, 0.3e-3), (0.2, 0.0)):
        way = np.sign(moved)
        run = solve_ivp(lambda _, z, way=way: (way - z) / PRESLIDING, (0.0, abs(moved)), [start], rtol=1e-10)
        assert slid(start, moved) == pytest.approx(run.y[0, -1], abs=1e-6)


def test_noise_is_that_of_two_motors_in_each_direction():
    record = device_with_sensor("straps", Device(strap_N=0.3))[0]
    assert record["cell_force"] == pytest.approx(0.3 * np.sqrt(2.0)) and record["cell_gain"] == 0.0
    assert record["cell_moment"] == pytest.approx(0.3 * np.sqrt(2.0) * 0.0275)
    assert device_with_sensor("cell", Device()) == Device().records()
    assert friction_noise("straps", Device()) == friction_noise("cell", Device()) == (0.0, 0.0)
    assert min(friction_noise("motors", Device())) > 0.0
    assert sds_of_sensor("cell", Device()) is None
