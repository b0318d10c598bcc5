"""Motors, servo and governor, kernel by kernel, against what is written about them."""

import newton_euler as twin
import numpy as np
import pytest
from far_limits import far_limits

import jawenv
from jawenv.device.comfort import GOVERNOR_ONSET
from jawenv.device.comfort_settings import Comfort
from jawenv.device.motors import (
    BRAKED,
    CAPPED,
    IDLE,
    ON_PATH,
    STOPPED,
    STOPPED_AND_BRAKED,
    Motors,
    command_motors,
    device_wrench,
)
from jawenv.kernels.records import record_dtype

TICK = 0.01
FORCE_CONTROL, TRAJECTORY = np.uint8(0), np.uint8(1)
Q = np.array([4e-3, 0.0, 0.2, 0.0, 0.0])
STILL = np.zeros(5)
OPEN = np.array([1.0, 1.0, 0.0, 0.0])


def device_record(**fields):
    return jawenv.Device(**fields).records()[0]


@pytest.fixture
def motors():
    record = np.zeros(1, dtype=record_dtype(Motors))[0]
    record["cap"] = 57.5
    return record


@pytest.fixture
def limits():
    return far_limits()


def command(device, jaw, motors, action, control=FORCE_CONTROL, q=Q, u=STILL):
    command_motors(device, jaw, motors, (tuple(q), tuple(u), ON_PATH), np.array(action, dtype=float), control, TICK)


def wrench(device, jaw, limits, motors, q=Q, u=STILL, since=0.0, control=FORCE_CONTROL):
    found, acted = device_wrench(device, jaw, limits, motors, (tuple(q), tuple(u), ON_PATH), since, control)
    return np.array(found), acted


def test_the_command_rises_no_faster_than_the_slew_limit(jaw, motors):
    device = device_record(slew_N_s=100.0, full_scale_N=10.0)
    commands = []
    for _ in range(12):
        command(device, jaw, motors, OPEN)
        commands.append(motors["command"].copy())
    np.testing.assert_allclose(np.array(commands)[:, 0], np.minimum(np.arange(1, 13), 10.0))
    np.testing.assert_array_equal(np.array(commands)[:, 2:], 0.0)


def test_thrust_follows_its_command_with_the_lag(jaw, motors):
    device = device_record(slew_N_s=1e5, lag_s=0.05, full_scale_N=10.0)
    thrusts = []
    for _ in range(20):
        command(device, jaw, motors, -OPEN)
        thrusts.append(motors["thrust"][0])
    np.testing.assert_allclose(thrusts, -10.0 * (1 - np.exp(-TICK * np.arange(1, 21) / 0.05)), rtol=1e-12)


def test_thrust_falls_with_speed_to_nothing_at_the_no_load_speed(jaw, motors):
    device = device_record(motor_no_load_mm_s=20.0, lever=0.25)
    moving = np.array([0.0, 0.0, 0.0, 0.3, 0.0])
    rate = -twin.measurement(jaw, np.concatenate([Q, moving]))[8]
    command(device, jaw, motors, OPEN, u=moving)
    assert motors["cap"][0] == pytest.approx(230 * 0.25 * (1 - abs(rate) / 0.080), rel=1e-12)
    fast = moving * 0.090 / rate
    motors["thrust"] = 10.0
    command(device, jaw, motors, OPEN, u=fast)
    np.testing.assert_array_equal(motors["cap"][:2], 0.0)
    np.testing.assert_array_equal(motors["thrust"][:2], 0.0)


def test_a_hot_motor_falls_back_to_its_continuous_thrust(jaw, motors):
    """Heat rises towards (thrust / continuous)^2; the peak lasts until it is 1."""
    device = device_record(full_scale_N=57.5, slew_N_s=1e5, lag_s=1e-4, thermal_s=2.0)
    thrusts = []
    for _ in range(200):
        command(device, jaw, motors, OPEN)
        thrusts.append(motors["thrust"][0])
    load = (230 / 150) ** 2
    expected = -2.0 * np.log(1 - 1 / load)
    assert thrusts[0] == pytest.approx(57.5)
    lasted = TICK * np.argmax(np.array(thrusts) < 57.0)
    assert lasted == pytest.approx(expected, abs=2 * TICK)
    assert min(thrusts) == pytest.approx(37.5)


def test_the_wrench_is_the_sum_of_the_motors_pushes(jaw, motors, limits, rng):
    """Forces along head axes on points of the turned mouthpiece; moments about the mouthpiece; body axes."""
    device = device_record()
    q = np.array([4e-3, 1e-3, 0.25, 0.08, -0.06])
    motors["thrust"] = thrust = rng.uniform(-5, 5, 4)
    R = twin.rotation(q)
    points = np.array([[0, 0.025, 0], [0, -0.025, 0], [0, 0.030, 0], [0, -0.030, 0]])
    pushes = thrust[:, None] * np.array([[0, 0, -1], [0, 0, -1], [1, 0, 0], [1, 0, 0]])
    expected = np.concatenate([R.T @ pushes.sum(axis=0), np.cross(points, pushes @ R).sum(axis=0)])
    found, acted = wrench(device, jaw, limits, motors, q)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)
    assert acted == IDLE


@pytest.mark.parametrize(("cap_N", "expected"), [(40.0, 24.0 * (1 + 0.5 * GOVERNOR_ONSET)), (9.0, 9.0)])
def test_the_motors_together_push_no_more_than_the_cap(jaw, motors, limits, cap_N, expected):
    """The governor's cap lies between soft and hard limit, or at the device's own, whichever is lower."""
    assert (Comfort().force_N, Comfort().force_hard) == (24.0, 1.5)
    motors["thrust"] = [30.0, 10.0, 20.0, 20.0]
    found, acted = wrench(device_record(force_cap_N=cap_N), jaw, limits, motors)
    uncapped = np.sqrt(40.0**2 + 40.0**2)
    assert acted == CAPPED
    assert np.linalg.norm(found[:3]) == pytest.approx(expected)
    moment = -20.0 * 0.025 * twin.rotation(Q)[0, 0]  # 20 N more down on the left, 25 mm out
    assert found[3] == pytest.approx(moment * expected / uncapped)


def test_the_servo_is_a_spring_and_damper_to_a_moving_target(jaw, motors, limits):
    device = device_record(servo_stiffness_N_m=1000.0, servo_damping_N_s_m=20.0)
    moving = np.array([0.01, 0.0, 0.0, 0.02, 0.0])
    state = np.concatenate([Q, moving])
    place, velocity = twin.measurement(jaw, state)[:3], twin.measurement(jaw, state)[6:9]
    forward = place[0] - jaw["mouthpiece"][0]
    motors["target"] = [0.0, 0.0, forward + 1e-3, forward + 1e-3]
    motors["rate"] = [0.0, 0.0, 0.010, 0.010]
    motors["cap"] = [0.0, 0.0, 50.0, 50.0]
    found, _ = wrench(device, jaw, limits, motors, u=moving, since=0.005, control=TRAJECTORY)
    each = 1000.0 * (1e-3 + 0.010 * 0.005) + 20.0 * (0.010 - velocity[0])
    np.testing.assert_allclose(twin.rotation(Q) @ found[:3], [2 * each, 0, 0], atol=1e-12)
    motors["cap"] = [0.0, 0.0, 0.3, 0.3]
    found, _ = wrench(device, jaw, limits, motors, u=moving, since=0.005, control=TRAJECTORY)
    np.testing.assert_allclose(twin.rotation(Q) @ found[:3], [0.6, 0, 0], atol=1e-12)


def test_a_target_does_not_run_away_from_a_jaw_that_cannot_follow(jaw, motors):
    """It leads by no more than full scale over stiffness at the end of the tick; its rate lags the action."""
    device = device_record(lag_s=0.02, max_rate_mm_s=40.0, full_scale_N=10.0, servo_stiffness_N_m=2500.0)
    opening = jaw["mouthpiece"][2] - twin.measurement(jaw, np.concatenate([Q, STILL]))[2]
    motors["target"][:2] = opening
    rates = []
    for _ in range(50):
        command(device, jaw, motors, OPEN, TRAJECTORY)
        rates.append(motors["rate"][0])
        motors["target"] += motors["rate"] * TICK
    np.testing.assert_allclose(rates, 0.040 * (1 - np.exp(-np.arange(1, 51) * TICK / 0.02)), rtol=1e-12)
    assert motors["target"][0] - opening == pytest.approx(10.0 / 2500.0)


def excursion_force(jaw, motors, limits, **change):
    for name, value in change.items():
        limits[name] = value
    found, acted = wrench(device_record(), jaw, limits, motors)
    return twin.rotation(Q) @ found[:3], acted


def test_each_end_stop_pushes_back(jaw, motors, limits):
    """Opened, forward and condyle-forward of limits that are set below where the jaw is."""
    place = twin.measurement(jaw, np.concatenate([Q, STILL]))[:3]
    opening = jaw["mouthpiece"][2] - place[2]
    force, acted = excursion_force(jaw, motors, limits.copy(), opening=0.8 * opening)
    assert acted == STOPPED
    assert force[2] > 0.0 and np.abs(force[:2]).max() < 1e-12
    force, acted = excursion_force(jaw, motors, limits.copy(), path=[place[0] - 1.0, 0.0, 0.0], fore_aft=0.8)
    assert acted == STOPPED
    assert force[0] < 0.0 and np.abs(force[1:]).max() < 1e-9 * abs(force[0])
    force, acted = excursion_force(jaw, motors, limits.copy(), rest_side=1.0, side=0.8)
    assert acted == STOPPED
    assert force[1] > 0.0 and np.abs(force[[0, 2]]).max() < 1e-9 * force[1]
    force, acted = excursion_force(jaw, motors, limits.copy(), condyle_half=2e-3)
    assert acted == STOPPED
    assert force[0] < 0.0


def test_the_condyles_stop_pushes_at_the_condyles_not_at_the_mouthpiece(jaw, motors, limits):
    """About the contact point it has no moment."""
    limits["condyle_half"] = 2e-3
    found, _ = wrench(device_record(), jaw, limits, motors)
    about_contact = found[3:] + np.cross(jaw["mouthpiece"], found[:3])
    np.testing.assert_allclose(about_contact, 0.0, atol=1e-12)
    assert np.linalg.norm(found[:3]) > 1.0


def test_the_brake_works_against_the_motion_only_above_the_soft_speed(jaw, motors, limits):
    slow, fast = np.array([0.0, 0.03, 0, 0, 0]), np.array([0.0, 0.30, 0, 0, 0])
    assert wrench(device_record(), jaw, limits, motors, u=slow)[1] == IDLE
    found, acted = wrench(device_record(brake_N_s_m=60.0), jaw, limits, motors, u=fast)
    onset = 0.04 * (1 + GOVERNOR_ONSET * (Comfort().speed_hard - 1))
    assert acted == BRAKED
    np.testing.assert_allclose(twin.rotation(Q) @ found[:3], [0, -60.0 * (0.30 - onset), 0], atol=1e-12)


def test_the_stiffest_part_that_acts_is_named(jaw, motors, limits):
    """A jaw past a stop that is too fast as well, with motors beyond the cap."""
    motors["thrust"] = [30.0, 10.0, 20.0, 20.0]
    fast = np.array([0.0, 0.30, 0, 0, 0])
    assert wrench(device_record(), jaw, limits, motors, u=fast)[1] == BRAKED
    limits["condyle_half"] = 2e-3
    assert wrench(device_record(), jaw, limits, motors, u=fast)[1] == STOPPED_AND_BRAKED
    assert wrench(device_record(), jaw, limits, motors, u=0.0 * fast)[1] == STOPPED
    assert IDLE < CAPPED < BRAKED < STOPPED < STOPPED_AND_BRAKED


def test_motors_yield_while_a_stop_is_pressed(jaw, motors, limits):
    """A stop pressed hard stands alone; free of it the motors push in full."""
    motors["thrust"] = [5.0, 5.0, 0.0, 0.0]
    free, _ = excursion_force(jaw, motors, limits.copy())
    np.testing.assert_allclose(free, [0, 0, -10.0], atol=1e-12)
    opening = jaw["mouthpiece"][2] - twin.measurement(jaw, np.concatenate([Q, STILL]))[2]
    pressed, _ = excursion_force(jaw, motors, limits.copy(), opening=0.7 * opening)
    motors["thrust"] = 0.0
    stop_alone, _ = excursion_force(jaw, motors, limits.copy(), opening=0.7 * opening)
    np.testing.assert_array_equal(pressed, stop_alone)
