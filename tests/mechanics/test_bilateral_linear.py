"""The derivatives of the two-condyle jaw, and the filter's step made of them, against the complex step."""

import newton_euler as twin
import numpy as np
import pytest
import two_condyles
from scipy.interpolate import lagrange

from jawenv.filter.bound.joint_recursion import joint_scratch_dtype
from jawenv.filter.model.encoders import measure_body
from jawenv.filter.model.joint_step import BODY_PARTS, propagate, step_parts
from jawenv.mechanics import build_jaw
from jawenv.mechanics.bilateral_linear import linearise_body
from jawenv.mechanics.dynamics import linear_dtype

DT = 0.01


@pytest.fixture
def jaw():
    return build_jaw(condyles=2)


@pytest.fixture
def scratch():
    return np.zeros(1, dtype=joint_scratch_dtype(6, 6, 12))[0]


def muscles_of(log_parameters):
    return np.exp(log_parameters).reshape(-1, 2)


def assert_close(actual, expected, relative):
    assert np.abs(actual - expected).max() <= relative * np.abs(expected).max()


def test_linearisation_is_the_exact_derivative(jaw, rng):
    linear = np.zeros(1, dtype=linear_dtype(6, 12, 6))[0]
    pressed = 0
    for _ in range(100):
        log_parameters, q, u, wrench = two_condyles.random_motion(jaw, rng)
        rate = linearise_body(jaw, muscles_of(log_parameters), tuple(q), tuple(u), tuple(wrench), linear)
        expected = two_condyles.acceleration(jaw, log_parameters, q, u, wrench)
        np.testing.assert_allclose(rate, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        by_state = twin.derivative(
            lambda s, p=log_parameters, w=wrench: two_condyles.acceleration(jaw, p, s[:6], s[6:], w),
            np.concatenate([q, u]),
        )
        by_input = twin.derivative(
            lambda s, q=q, u=u: two_condyles.acceleration(jaw, s[:12], q, u, s[12:]),
            np.concatenate([log_parameters, wrench]),
        )
        for part in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)):
            assert_close(linear["by_state"][:, part], by_state[:, part], 1e-8)
        for part in (slice(0, 12), slice(12, 15), slice(15, 18)):
            assert_close(linear["by_input"][:, part], by_input[:, part], 1e-8)
        pressed += sum(two_condyles.disc(jaw, *condyle)[1] > 0 for condyle in two_condyles.condyles(jaw, q, u))
    assert 50 < pressed < 150, "some discs are pressed, some are not"


def step_of_the_model(jaw, mean, samples, trend, parts):
    """The filter's step for complex arguments: Runge-Kutta in parts, the load cell's samples joined by a parabola."""
    wrench_at = [lagrange([0.0, 0.5, 1.0], samples[:, k]) for k in range(6)]

    def rate(t, s):
        wrench = np.array([polynomial(t / DT) for polynomial in wrench_at]) + mean[24] * trend
        pose = two_condyles.five(s[:6])
        angles = np.linalg.solve(np.array(twin.angle_axes(pose)), s[9:])
        return np.concatenate([s[6:9], angles, two_condyles.acceleration(jaw, mean[12:24], s[:6], s[6:], wrench)])

    state, h = mean[:12], DT / parts
    for part in range(parts):
        t = part * h
        k1 = rate(t, state)
        k2 = rate(t + h / 2, state + h / 2 * k1)
        k3 = rate(t + h / 2, state + h / 2 * k2)
        k4 = rate(t + h, state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return state


def test_the_filters_step_and_its_derivative(jaw, rng, scratch):
    divided = []
    for _ in range(10):
        log_parameters, q, u, wrench = two_condyles.random_motion(jaw, rng)
        mean = np.concatenate([q, 0.1 * u, log_parameters, [0.01]])
        samples, trend = wrench / 5 + rng.normal(size=(3, 6)) * [0.5] * 6, wrench / 5
        state, parts = mean.copy(), step_parts(jaw, muscles_of(log_parameters), mean, DT, scratch["linear"])
        expected = step_of_the_model(jaw, mean, samples, trend, parts)
        divided.append(parts)
        propagate(jaw, muscles_of(log_parameters), state, samples, trend, mean[24], DT, scratch)
        np.testing.assert_allclose(state[:12], expected, rtol=1e-9, atol=1e-11)
        derivative = twin.derivative(lambda s, a=samples, b=trend, n=parts: step_of_the_model(jaw, s, a, b, n), mean)
        for rows in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)):
            for columns in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12), slice(12, 24), slice(24, 25)):
                assert_close(scratch["total"][rows, columns], derivative[rows, columns], 1e-7)
    assert min(divided) == BODY_PARTS < max(divided), "some are so stiff that they take more parts"


def test_what_the_encoders_read(jaw, rng):
    rows, expected = np.empty((12, 12)), np.empty(12)
    for _ in range(20):
        _, q, u, _ = two_condyles.random_motion(jaw, rng)

        def reading(s, jaw=jaw):
            R = twin.rotation(two_condyles.five(s[:6]))
            arm = jaw["mouthpiece"]
            return np.concatenate([s[:3] + R @ arm, s[3:6], s[6:9] + R @ np.cross(s[9:], arm), s[9:]])

        state = np.concatenate([q, u])
        measure_body(jaw, state, rows, expected)
        np.testing.assert_allclose(expected, reading(state), rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(rows, twin.derivative(reading, state), rtol=1e-9, atol=1e-12)
