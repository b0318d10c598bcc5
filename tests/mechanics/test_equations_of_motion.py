"""The compiled equations of motion against the independent rigid body in ``newton_euler``."""

import newton_euler as twin
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jawenv
from jawenv.anatomy import default_fossa
from jawenv.mechanics.dynamics import linear_dtype, linearise_acceleration, state_rate
from jawenv.mechanics.kinematics import angle_rates, fossa, rotation

FREE, PRESSED = "off the stops", "on the stops"


def random_motion(rng, where):
    """Log-parameters, q, u and a wrench; on the stops, teeth and capsule are pressed."""
    log_parameters = jawenv.cohort("trismus").draw_log_parameters(rng)
    theta = rng.uniform(0.08, 0.5) if where == FREE else rng.uniform(-0.05, 0.0)
    crest = default_fossa().crest_m
    x = rng.uniform(0.5e-3, crest) if where == FREE else rng.choice([-1e-3, -0.2e-3, crest + 1e-3])
    q = np.array([x, rng.uniform(-2e-3, 2e-3), theta, *rng.uniform(-0.1, 0.1, 2)])
    u = np.concatenate([rng.uniform(-0.05, 0.05, 2), rng.uniform(-2, 2, 3)])
    wrench = np.concatenate([rng.uniform(-20, 20, 3), rng.uniform(-0.5, 0.5, 3)])
    return log_parameters, q, u, wrench


@pytest.fixture
def jaw(jaw):
    """The default jaw with a tone of its closers."""
    jaw["tone"] = 0.5
    return jaw


def record_muscles(log_parameters):
    return np.exp(log_parameters).reshape(6, 2)


def assert_close(actual, expected, relative):
    """Close relative to the largest of the numbers that share a unit: linear rows, then angular rows."""
    for rows in (slice(0, 2), slice(2, 5)):
        assert np.abs(actual[rows] - expected[rows]).max() < relative * np.abs(expected[rows]).max()


@pytest.mark.parametrize("where", [FREE, PRESSED])
def test_acceleration_is_that_of_the_constrained_rigid_body(jaw, rng, where):
    for _ in range(50):
        log_parameters, q, u, wrench = random_motion(rng, where)
        expected = twin.acceleration(jaw, log_parameters, q, u, wrench).real
        actual = jawenv.acceleration(jaw, q, u, log_parameters, wrench)
        assert_close(actual, expected, 1e-9)


def test_the_random_poses_meet_both_kinds_of_stop(jaw, rng):
    def stop_energy(q):
        stiff, soft = jaw.copy(), jaw.copy()
        soft["tooth_stiffness"] = soft["condyle_stiffness"] = 0.0
        still, parameters = np.zeros(5), np.zeros(12)
        return twin.energy(stiff, parameters, q, still) - twin.energy(soft, parameters, q, still)

    assert all(stop_energy(random_motion(rng, FREE)[1]) == 0.0 for _ in range(50))
    assert all(stop_energy(random_motion(rng, PRESSED)[1]) > 0.0 for _ in range(50))


@pytest.mark.parametrize("where", [FREE, PRESSED])
def test_linearisation_is_the_exact_derivative(jaw, rng, where):
    linear = np.zeros(1, dtype=linear_dtype(6, n_muscles=6))[0]
    for _ in range(50):
        log_parameters, q, u, wrench = random_motion(rng, where)
        rate = linearise_acceleration(jaw, record_muscles(log_parameters), tuple(q), tuple(u), tuple(wrench), linear)
        np.testing.assert_allclose(rate, jawenv.acceleration(jaw, q, u, log_parameters, wrench), rtol=1e-9, atol=1e-9)
        by_state = twin.derivative(
            lambda s, p=log_parameters, w=wrench: twin.acceleration(jaw, p, s[:5], s[5:], w), np.concatenate([q, u])
        )
        by_input = twin.derivative(
            lambda s, q=q, u=u: twin.acceleration(jaw, s[:12], q, u, s[12:]), np.concatenate([log_parameters, wrench])
        )
        for part in (slice(0, 2), slice(2, 5), slice(5, 7), slice(7, 10)):
            assert_close(linear["by_state"][:, part], by_state[:, part], 1e-8)
        for part in (slice(0, 12), slice(12, 15), slice(15, 18)):
            assert_close(linear["by_input"][:, part], by_input[:, part], 1e-8)


def test_power_of_the_device_less_damping_is_the_gain_of_energy(jaw, rng):
    """Along any motion, stops included: d(energy)/dt = F . v + M . omega - damping."""
    for where in (FREE, PRESSED):
        for _ in range(25):
            log_parameters, q, u, wrench = random_motion(rng, where)
            q_rate, u_rate = map(
                np.array, state_rate(jaw, record_muscles(log_parameters), tuple(q), tuple(u), tuple(wrench))
            )
            step = 1j * twin.IMAGINARY_STEP
            gain = twin.energy(jaw, log_parameters, q + step * q_rate, u + step * u_rate).imag / twin.IMAGINARY_STEP
            velocity = twin.rotation(q).T @ twin.measurement(jaw, np.concatenate([q, u]))[6:9]
            slide = np.array([u[0], u[1], twin.fossa(jaw, q[0])[1] * u[0]])
            power = wrench[:3] @ velocity + wrench[3:] @ u[2:]
            loss = jaw["damping_sliding"] * slide @ slide + jaw["damping_rotation"] * u[2:] @ u[2:]
            assert gain == pytest.approx(power - loss, rel=1e-9, abs=1e-9)


def test_energy_is_conserved_without_damping_and_device(jaw):
    jaw["tone"] = 0.05  # a stronger one would close it
    jaw["damping_rotation"] = jaw["damping_sliding"] = 0.0
    log_parameters = np.log(np.tile([0.4, 7.0], 6))
    muscles = record_muscles(log_parameters)
    # It swings about the place where it hangs open, clear of the stops, whose force is not smooth enough for 1e-8.
    state = np.array([5e-3, 0.3e-3, 0.2, 0.02, -0.01, 0.0, 0.0, 0.1, 0.2, -0.1])
    start, nothing = state.copy(), (0.0,) * 6

    def rate(_, s):
        q_rate, u_rate = state_rate(jaw, muscles, tuple(s[:5]), tuple(s[5:]), nothing)
        return np.array(q_rate + u_rate)

    at_start = twin.energy(jaw, log_parameters, start[:5], start[5:])
    kinetic, drift, openings = [], [], []
    for _ in range(4000):
        state = twin.runge_kutta(rate, state, 0.25e-3)
        still = twin.energy(jaw, log_parameters, state[:5], np.zeros(5))
        now = twin.energy(jaw, log_parameters, state[:5], state[5:])
        kinetic.append(now - still)
        drift.append(abs(now - at_start))
        openings.append(state[2])
    assert np.ptp(openings) > 0.05, "the jaw does swing"
    assert max(drift) < 1e-8 * max(kinetic)


def mirror(vector, flip):
    mirrored = np.array(vector, dtype=float)
    mirrored[list(flip)] *= -1
    return mirrored


def test_left_and_right_are_mirror_images(jaw, rng):
    """Muscles swapped, and y, psi, alpha, omega_x, omega_z, F_y, M_x, M_z of the other sign."""
    for where in (FREE, PRESSED):
        for _ in range(25):
            log_parameters, q, u, wrench = random_motion(rng, where)
            swapped = np.concatenate([log_parameters[6:], log_parameters[:6]])
            other = jawenv.acceleration(
                jaw, mirror(q, (1, 3, 4)), mirror(u, (1, 2, 4)), swapped, mirror(wrench, (1, 3, 5))
            )
            expected = jawenv.acceleration(jaw, q, u, log_parameters, wrench)
            np.testing.assert_allclose(mirror(other, (1, 2, 4)), expected, rtol=1e-12, atol=1e-10)


def test_rotation_is_pitch_then_yaw_then_roll(rng):
    for _ in range(20):
        q = np.concatenate([[0, 0], rng.uniform(-1, 1, 3)])
        np.testing.assert_allclose(
            np.array(rotation(tuple(q))), Rotation.from_euler("YZX", q[2:]).as_matrix(), atol=1e-15
        )


def test_angle_rates_turn_the_body_with_its_angular_velocity(rng):
    h = 1e-6
    for _ in range(20):
        q = np.concatenate([[0, 0], rng.uniform(-0.8, 0.8, 3)])
        omega = rng.uniform(-2, 2, 3)
        rates = np.array(angle_rates(tuple(q), tuple(omega)))
        turned = [Rotation.from_euler("YZX", q[2:] + side * h * rates) for side in (-1, 1)]
        np.testing.assert_allclose((turned[0].inv() * turned[1]).as_rotvec() / (2 * h), omega, atol=1e-8)


def test_fossa_derivatives(jaw):
    for x in np.linspace(-1e-3, 11e-3, 13):
        of_x = twin.derivative(lambda s: np.array(twin.fossa(jaw, s[0])), np.array([x]))[:, 0]
        z, *derivatives = fossa(jaw, x)
        assert z == pytest.approx(twin.fossa(jaw, x)[0], abs=1e-15)
        np.testing.assert_allclose(derivatives, of_x, rtol=1e-12, atol=1e-12)


def test_a_force_without_moment_is_a_force_at_the_mouthpiece(jaw, rng):
    log_parameters, q, u, wrench = random_motion(rng, FREE)
    wrench[3:] = 0.0
    with_moment = jawenv.acceleration(jaw, q, u, log_parameters, wrench)
    np.testing.assert_array_equal(jawenv.acceleration(jaw, q, u, log_parameters, wrench[:3]), with_moment)
