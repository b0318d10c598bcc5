"""The servo's answer to the jaw's motion, against differences of the wrench that the motors give."""

import newton_euler as twin
import numpy as np
import pytest

import jawenv
from jawenv.device.comfort import limits_dtype
from jawenv.device.motors import device_wrench
from jawenv.device.servo import set_servo
from jawenv.envs.world import MOTORS
from jawenv.mechanics import build_jaw
from jawenv.mechanics.kinematics import rotation

TRAJECTORY = np.uint8(1)
POSES = [(4e-3, 0.0, 0.2, 0.0, 0.0), (8e-3, 1e-3, 0.3, 0.08, -0.05), (0.0, -2e-3, 0.05, -0.1, 0.07)]
STEP = 1e-7


def far_limits():
    limits = np.zeros(1, dtype=limits_dtype(6))[0]
    for name in limits.dtype.names:
        limits[name] = 10.0
    limits["path"] = limits["rest_opening"] = limits["rest_side"] = limits["rest_condyle_side"] = 0.0
    limits["condyle_middle"] = 0.0
    return limits


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

    def wrench(self, state):
        """(6,) the motors' own at a state."""
        lift = (0.0, 0.0)
        if self.condyles == 2:
            height, slope, _ = twin.fossa(self.jaw, state[0])
            lift = float(state[2] - height), float(state[8] - slope * state[6])
            state = np.delete(state, [2, 8])
        q, u = tuple(float(v) for v in state[:5]), tuple(float(v) for v in state[5:])
        return np.array(device_wrench(self.device, self.jaw, self.limits, self.motors, q, u, lift, 0.0, TRAJECTORY)[0])

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
        found = np.full((6, len(self.start)), np.nan)
        body_to_head = rotation(tuple(self.pose))
        set_servo(self.device, tuple(self.jaw["mouthpiece"]), self.by_place(), body_to_head, found)
        return found


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
