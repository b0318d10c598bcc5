"""The answer of servos and brake to the jaw's motion, against differences of the wrench that the device gives."""

import newton_euler as twin
import numpy as np
import pytest
from far_limits import far_limits

import jawenv
from jawenv.device.answer import add_brake, add_servos
from jawenv.device.motors import BRAKE_ONSET, YIELD_FORCE, device_wrench
from jawenv.envs.world import MOTORS
from jawenv.mechanics import build_jaw
from jawenv.mechanics.kinematics import rotation

FORCE, TRAJECTORY = np.uint8(0), np.uint8(1)
POSES = [(4e-3, 0.0, 0.2, 0.0, 0.0), (8e-3, 1e-3, 0.3, 0.08, -0.05), (0.0, -2e-3, 0.05, -0.1, 0.07)]
STEP = 1e-7


class Held:
    """A jaw where the motors' targets are, so that no motor pushes; its state deviates from there.

    ``condyles`` 1: (q, u) of the midline model; 2: those of the body, whose reference point is free.
    """

    def __init__(self, pose, condyles, **fields):
        self.jaw, self.device, self.condyles = build_jaw(), jawenv.Device(**fields).records()[0], condyles
        self.pose, self.limits = np.array(pose), far_limits()
        self.start = np.concatenate([pose, np.zeros(5)])
        if condyles == 2:
            self.start = np.concatenate([twin.contact(self.jaw, self.pose), pose[2:], np.zeros(6)])
        self.motors = np.zeros(1, dtype=MOTORS)[0]
        self.motors["cap"] = 50.0
        place = twin.contact(self.jaw, self.pose)
        arms = (self.jaw["mouthpiece"] + self.device["point"]) @ twin.rotation(self.pose).T
        from_closed = place + arms - self.jaw["mouthpiece"] - self.device["point"]
        self.motors["target"] = np.sum(from_closed * self.device["direction"], axis=1)

    def wrench(self, state, control=TRAJECTORY):
        """(6,) the device's at a state."""
        lift = (0.0, 0.0)
        if self.condyles == 2:
            height, slope, _ = twin.fossa(self.jaw, state[0])
            lift = float(state[2] - height), float(state[8] - slope * state[6])
            state = np.delete(state, [2, 8])
        q, u = tuple(float(v) for v in state[:5]), tuple(float(v) for v in state[5:])
        return np.array(device_wrench(self.device, self.jaw, self.limits, self.motors, q, u, lift, 0.0, control)[0])

    def by_place(self):
        """Directions of the reference point and axes of the angles, body axes, from the independent jaw."""
        R = twin.rotation(self.pose)
        slides = (
            np.eye(3)
            if self.condyles == 2
            else np.array([[1.0, 0.0, twin.fossa(self.jaw, self.pose[0])[1]], [0, 1.0, 0]])
        )
        return np.vstack([slides @ R, twin.angle_axes(self.pose).T])

    def servo(self):
        found = np.zeros((6, len(self.start)))
        body_to_head = rotation(tuple(self.pose))
        add_servos(self.device, tuple(self.jaw["mouthpiece"]), self.by_place(), body_to_head, found)
        return found

    def moving(self, speeds):
        """The state at the pose with these velocities of its coordinates."""
        half = len(self.start) // 2
        return np.concatenate([self.start[:half], speeds])

    def by_speed(self, state):
        """(6, n / 2) by what the wrench falls as each velocity grows, the motors' forces commanded."""
        half = len(state) // 2
        falls = [
            (self.wrench(state - STEP * one, FORCE) - self.wrench(state + STEP * one, FORCE)) / (2.0 * STEP)
            for one in np.eye(len(state))[half:]
        ]
        return np.column_stack(falls)

    def brake(self, state, speeds_cov=None, reading=None):
        """Whether the brake works at a state, and its answer; speeds are known where no covariance is given."""
        found, half = np.zeros((6, len(state))), len(state) // 2
        reading = self.wrench(state, FORCE) if reading is None else reading
        cov = np.zeros((half, half)) if speeds_cov is None else speeds_cov
        mouthpiece = tuple(self.jaw["mouthpiece"])
        works = add_brake(
            self.device, mouthpiece, self.by_place(), state[half:], cov, reading, found, np.zeros(half)
        )  # fmt: skip
        return works, found


@pytest.mark.parametrize("condyles", [1, 2])
@pytest.mark.parametrize("pose", POSES)
def test_the_wrench_falls_by_the_servo_as_the_jaw_moves_away(pose, condyles):
    held = Held(pose, condyles)
    np.testing.assert_allclose(held.wrench(held.start), 0.0, atol=1e-9)
    falls = np.column_stack(
        [
            (held.wrench(held.start - STEP * one) - held.wrench(held.start + STEP * one)) / (2.0 * STEP)
            for one in np.eye(len(held.start))
        ]
    )
    servo = held.servo()
    np.testing.assert_allclose(servo, falls, rtol=1e-6, atol=1e-6 * np.abs(falls).max())


def test_stiffness_and_damping_each_in_its_own_half():
    usual, half = Held(POSES[1], 1), 5
    softer, looser = Held(POSES[1], 1, servo_stiffness_N_m=1250.0), Held(POSES[1], 1, servo_damping_N_s_m=7.5)
    np.testing.assert_allclose(softer.servo()[:, :half], 0.5 * usual.servo()[:, :half], rtol=1e-12)
    np.testing.assert_array_equal(softer.servo()[:, half:], usual.servo()[:, half:])
    np.testing.assert_allclose(looser.servo()[:, half:], 0.5 * usual.servo()[:, half:], rtol=1e-12)
    np.testing.assert_array_equal(looser.servo()[:, :half], usual.servo()[:, :half])


def fast(held, rng, speed):
    """Random velocities with which the mouthpiece has this speed (m/s)."""
    half = len(held.start) // 2
    speeds = np.concatenate([0.1 * rng.normal(size=half - 3), 2.0 * rng.normal(size=3)])
    spin = np.cross(speeds[-3:], held.jaw["mouthpiece"])
    return speeds * speed / np.linalg.norm(speeds[:-3] @ held.by_place()[:-3] + spin)


@pytest.mark.parametrize("condyles", [1, 2])
@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("speed", [0.07, 0.2, 0.5])
def test_the_wrench_falls_by_the_brake_as_the_jaw_moves_faster(pose, condyles, speed, rng):
    """With motors that push, half yield, and have yielded altogether."""
    held = Held(pose, condyles)
    held.motors["thrust"] = rng.normal(size=4)
    state = held.moving(fast(held, rng, speed))
    works, answer = held.brake(state)
    half = len(state) // 2
    falls = held.by_speed(state)
    assert works and np.abs(falls).max() > 1.0
    assert (held.device["brake"] * (speed - BRAKE_ONSET) < YIELD_FORCE) == (speed < 0.3)
    np.testing.assert_array_equal(answer[:, :half], 0.0)
    np.testing.assert_allclose(answer[:, half:], falls, rtol=1e-6, atol=1e-6 * np.abs(falls).max())


def test_a_slow_jaw_is_not_braked(rng):
    held = Held(POSES[1], 1)
    works, answer = held.brake(held.moving(fast(held, rng, 0.99 * BRAKE_ONSET)))
    assert not works and not answer.any()


@pytest.mark.parametrize("condyles", [1, 2])
@pytest.mark.parametrize(("speed", "sd"), [(0.9, 0.2), (1.0, 0.1), (1.1, 0.3), (0.7, 0.2)])
def test_where_the_speed_is_uncertain_the_brake_is_what_its_force_follows_on_average(condyles, speed, sd, rng):
    """The regression of the device's own wrench on the speed, by quadrature; both in parts of the brake's onset."""
    held = Held(POSES[1], condyles)
    state = held.moving(fast(held, rng, speed * BRAKE_ONSET))
    half = len(state) // 2
    faster = np.linspace(-6.0, 6.0, 2001) * sd / speed
    weight = np.exp(-0.5 * (faster * speed / sd) ** 2)
    weight /= weight.sum()
    wrenches = np.array([held.wrench(held.moving(state[half:] * (1.0 + one)), FORCE) for one in faster])
    regression = -(weight * faster) @ wrenches / (weight @ faster**2)
    cov = np.outer(state[half:], state[half:]) * (sd / speed) ** 2
    works, answer = held.brake(state, cov, reading=weight @ wrenches)
    assert works and np.linalg.norm(regression[:3]) > 1e-3 * held.device["brake"] * BRAKE_ONSET
    np.testing.assert_allclose(answer[:, half:] @ state[half:], regression, rtol=1e-4, atol=1e-9)


def test_a_jaw_at_rest_is_not_braked_however_uncertain_it_is():
    held = Held(POSES[1], 1)
    works, answer = held.brake(held.start, np.eye(5))
    assert not works and not answer.any()
