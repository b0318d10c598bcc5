"""The compiled equations of motion against the independent rigid body in ``newton_euler``."""

import newton_euler as twin
import numpy as np
import pytest

import jawenv
from jawenv.anatomy import default_fossa
from jawenv.mechanics.dynamics import linear_dtype, linearise_acceleration

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


def test_a_force_without_moment_is_a_force_at_the_mouthpiece(jaw, rng):
    log_parameters, q, u, wrench = random_motion(rng, FREE)
    wrench[3:] = 0.0
    with_moment = jawenv.acceleration(jaw, q, u, log_parameters, wrench)
    np.testing.assert_array_equal(jawenv.acceleration(jaw, q, u, log_parameters, wrench[:3]), with_moment)
