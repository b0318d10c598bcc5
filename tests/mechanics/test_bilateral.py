"""The compiled jaw with two condyles against MuJoCo's free body, its energy, its mirror image and its rest."""

import newton_euler as twin
import numpy as np
import pytest
import two_condyles
from bilateral_step import bilateral_step
from hypothesis import given, settings
from hypothesis import strategies as st

import jawenv
from jawenv.mechanics import build_jaw
from jawenv.mechanics.bilateral import (
    bilateral_rate,
    body_acceleration,
    condyle_pressures,
    put_on_fossa,
    settle_bilateral,
)
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.kinematics import midline_motion, split_body

NOTHING = (0.0,) * 6
FLIP_Q, FLIP_U, FLIP_WRENCH = [1, 4, 5], [1, 3, 5], [1, 3, 5]


def record_muscles(log_parameters):
    return np.exp(log_parameters).reshape(-1, 2)


def accelerate(jaw, log_parameters, q, u, wrench):
    return np.array(body_acceleration(jaw, record_muscles(log_parameters), tuple(q), tuple(u), tuple(wrench)))


def rested(jaw, log_parameters, wrench=NOTHING):
    """State (12) at rest and the midline model's pose (5) from which it started."""
    muscles, pose, state = record_muscles(log_parameters), np.array([3e-3, 0.0, 0.05, 0.0, 0.0]), np.empty(12)
    settle(jaw, muscles, pose, 0.0, False, np.zeros(1, dtype=linear_dtype(6))[0], np.empty((5, 5)), np.empty(5))
    put_on_fossa(jaw, pose, state)
    assert settle_bilateral(jaw, muscles, wrench, state, np.empty((6, 6)), np.empty(6))
    return state, pose


def test_acceleration_is_that_of_mujocos_free_body(jaw, rng):
    body = two_condyles.FreeBody(jaw)
    lifted = []
    for _ in range(200):
        log_parameters, q, u, wrench = two_condyles.random_motion(jaw, rng)
        expected = body.acceleration(jaw, log_parameters, q, u, wrench)
        actual = accelerate(jaw, log_parameters, q, u, wrench)
        for rows in (slice(0, 3), slice(3, 6)):
            assert np.abs(actual[rows] - expected[rows]).max() < 1e-10 * np.abs(expected[rows]).max()
        lifted.append(np.array(condyle_pressures(jaw, tuple(q), tuple(u))) == 0.0)
    assert {tuple(pair) for pair in lifted} == {(False, False), (False, True), (True, False), (True, True)}


def test_pressure_is_the_disc_of_the_reference(jaw, rng):
    for _ in range(50):
        _, q, u, _ = two_condyles.random_motion(jaw, rng)
        expected = [two_condyles.disc(jaw, *motion)[1] for motion in two_condyles.condyles(jaw, q, u)]
        np.testing.assert_allclose(condyle_pressures(jaw, tuple(q), tuple(u)), expected, rtol=1e-9, atol=1e-12)


def test_power_of_the_device_less_damping_is_the_gain_of_energy(jaw, rng):
    for _ in range(50):
        log_parameters, q, u, wrench = two_condyles.random_motion(jaw, rng)
        rates = bilateral_rate(jaw, record_muscles(log_parameters), tuple(q), tuple(u), tuple(wrench))
        q_rate, u_rate = map(np.array, rates)
        step = 1j * twin.IMAGINARY_STEP
        gain = two_condyles.energy(jaw, log_parameters, q + step * q_rate, u + step * u_rate).imag / twin.IMAGINARY_STEP
        R = twin.rotation(two_condyles.five(q))
        velocity = R.T @ u[:3] + np.cross(u[3:], jaw["mouthpiece"])
        power = wrench[:3] @ velocity + wrench[3:] @ u[3:]
        assert gain == pytest.approx(power - two_condyles.loss(jaw, q, u), rel=1e-9, abs=1e-9)


def swing(jaw, log_parameters, seconds, h):
    """Energy and lost power at every step of a swing from rest, and whether the discs were pressed."""
    state, _ = rested(jaw, log_parameters)
    state[6:] = [0.02, 0.01, 0.0, 0.4, 0.6, -0.3]
    muscles, energies, losses, pressed = record_muscles(log_parameters), [], [], []
    for _ in range(round(seconds / h)):
        energies.append(two_condyles.energy(jaw, log_parameters, state[:6], state[6:]))
        losses.append(two_condyles.loss(jaw, state[:6], state[6:]))
        pressed.append(np.array(condyle_pressures(jaw, *split_body(state))) > 0.0)
        bilateral_step(jaw, muscles, state, NOTHING, h)
    return np.array(energies), np.array(losses), np.array(pressed)


def test_energy_is_kept_without_damping_also_where_condyles_lift_off(jaw):
    jaw["damping_rotation"] = jaw["damping_sliding"] = jaw["disc_damping"] = 0.0
    log_parameters = np.log(np.tile([0.4, 7.0], 6))
    drifts = []
    for h in (1e-4, 0.5e-4):
        energies, _, pressed = swing(jaw, log_parameters, 0.5, h)
        drifts.append(np.abs(energies - energies[0]).max())
        assert pressed.any() and not pressed.all()
    moving = 0.5 * 0.30 * 0.02**2
    assert drifts[0] < 1e-4 * moving
    assert drifts[1] < 0.3 * drifts[0], "what drifts is the step's error, not the forces'"


def test_with_damping_the_loss_of_energy_is_the_work_of_the_dampers(jaw):
    energies, losses, _ = swing(jaw, np.log(np.tile([1.2, 7.0], 6)), 0.5, 1e-4)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (losses[1:] + losses[:-1]) * 1e-4)])
    assert np.all(losses >= 0.0)
    assert np.abs(energies[0] - energies - work).max() < 1e-3 * work[-1]


def bounded(size):
    return st.floats(-size, size)


JAW = build_jaw()


@given(
    st.lists(bounded(1.0), min_size=12, max_size=12),
    st.tuples(st.floats(-1e-3, 0.014), *map(bounded, (2e-3, 3e-4, 0.4, 0.03, 0.03))),
    st.tuples(*map(bounded, (0.1, 0.1, 0.1, 3.0, 3.0, 3.0))),
    st.tuples(*map(bounded, (20.0, 20.0, 20.0, 1.0, 1.0, 1.0))),
)
@settings(deadline=None, max_examples=200)
def test_left_and_right_are_mirror_images(spread, q, u, wrench):
    log_parameters = np.log(np.tile([1.2, 7.0], 6)) + 0.5 * np.array(spread)
    q = np.array(q)
    q[2] += twin.fossa(JAW, q[0])[0]

    def mirrored(vector, flip):
        other = np.array(vector)
        other[flip] *= -1
        return other

    expected = accelerate(JAW, log_parameters, q, u, wrench)
    swapped = np.concatenate([log_parameters[6:], log_parameters[:6]])
    other = accelerate(JAW, swapped, mirrored(q, FLIP_Q), mirrored(u, FLIP_U), mirrored(wrench, FLIP_WRENCH))
    np.testing.assert_allclose(mirrored(other, FLIP_U), expected, rtol=1e-10, atol=1e-8)


@pytest.mark.parametrize("name", ["trismus", "healthy", "severe", "one_sided", "blockage", "wide"])
def test_at_rest_nothing_accelerates_and_a_push_dies_away(jaw, rng, name):
    for _ in range(20):
        log_parameters = jawenv.cohort(name).draw_log_parameters(rng)
        state, _ = rested(jaw, log_parameters)
        np.testing.assert_allclose(accelerate(jaw, log_parameters, state[:6], state[6:], np.zeros(6)), 0.0, atol=1e-8)
        pushed, muscles = state.copy(), record_muscles(log_parameters)
        pushed[6:] = rng.normal(0.0, [1e-4] * 3 + [1e-3] * 3)
        for _ in range(500):
            bilateral_step(jaw, muscles, pushed, NOTHING, 1e-3)
        np.testing.assert_allclose(pushed[:6], state[:6], atol=1e-3)
        np.testing.assert_allclose(pushed[6:], 0.0, atol=1e-3)


def test_equal_sides_rest_in_the_midline_near_the_midline_models_pose(jaw):
    state, pose = rested(jaw, np.log(np.tile([1.2, 7.0], 6)))
    np.testing.assert_allclose(state[[1, 4, 5]], 0.0, atol=1e-12)
    coordinates, speeds, lift, rate = midline_motion(jaw, *split_body(state))
    np.testing.assert_allclose(coordinates, pose, atol=2e-3)
    assert speeds == (0.0,) * 5 and rate == 0.0
    assert 0.0 < lift < 0.1e-3, "the discs give way"
    left, right = condyle_pressures(jaw, *split_body(state))
    assert left == pytest.approx(right, rel=1e-9) and left > 0.5


def test_motion_in_midline_coordinates(jaw, rng):
    h = 1e-7
    for _ in range(10):
        _, q, u, _ = two_condyles.random_motion(jaw, rng)
        coordinates, speeds, lift, rate = midline_motion(jaw, tuple(q), tuple(u))
        np.testing.assert_array_equal(coordinates, q[[0, 1, 3, 4, 5]])
        np.testing.assert_array_equal(speeds, u[[0, 1, 3, 4, 5]])
        assert lift == pytest.approx(q[2] - twin.fossa(jaw, q[0])[0], abs=1e-15)
        lifts = [q[2] + s * h * u[2] - twin.fossa(jaw, q[0] + s * h * u[0])[0] for s in (-1, 1)]
        assert rate == pytest.approx((lifts[1] - lifts[0]) / (2 * h), abs=1e-8)


def test_held_on_the_path_it_is_the_midline_model(jaw, rng):
    """A normal force instead of the discs, such that the midpoint stays on its path: the same motion."""
    jaw["disc_stiffness"], jaw["disc_damping"] = 1e-12, 0.0
    jaw["damping_sliding"] = 0.0  # at two condyles it resists yaw and roll as well
    for _ in range(50):
        log_parameters, q, u, wrench = two_condyles.random_motion(jaw, rng)
        q[0] = rng.uniform(2e-3, jaw["crest"] - 2e-3)
        q[2], slope, curvature = twin.fossa(jaw, q[0])
        u[2] = slope * u[0]
        normal = twin.rotation(two_condyles.five(q)).T @ [-slope, 0.0, 1.0]
        at_mouthpiece = np.concatenate([normal, -np.cross(jaw["mouthpiece"], normal)])
        free = accelerate(jaw, log_parameters, q, u, wrench)
        pushed = accelerate(jaw, log_parameters, q, u, wrench + at_mouthpiece)
        leaves = [a[2] - slope * a[0] - curvature * u[0] ** 2 for a in (free, pushed)]
        held = free - leaves[0] / (leaves[1] - leaves[0]) * (pushed - free)
        coordinates, speeds, _, _ = midline_motion(jaw, tuple(q), tuple(u))
        expected = jawenv.acceleration(jaw, coordinates, speeds, log_parameters, wrench)
        np.testing.assert_allclose(held[[0, 1, 3, 4, 5]], expected, rtol=1e-8, atol=1e-8)
