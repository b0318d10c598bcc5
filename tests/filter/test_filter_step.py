"""The model's step and its exact derivative, and the encoders, against an independent model."""

import newton_euler as twin
import numpy as np
import pytest
from joint_belief import DT, GAIN, PARAMETERS, STATE, Belief, jacobians, model_step
from numpy_model import fastest_rate as independent_rate
from numpy_model import parts_needed as independent_parts
from numpy_model import step_with_derivative

from jawenv.filter.bound.joint_recursion import joint_scratch_dtype
from jawenv.filter.bound.joint_step import propagate
from jawenv.filter.model.encoders import measure
from jawenv.filter.readings.cell_trend import TREND_TIME, follow_trend
from jawenv.mechanics.stiffness import fastest_rate, parts_needed


@pytest.fixture
def scratch():
    return np.zeros(1, dtype=joint_scratch_dtype())[0]


def test_the_step_and_its_jacobian(jaw, rng, scratch):
    """All 35 columns: states, log-parameters, load-cell gain, wrench not known, constant and tilting."""
    for _ in range(10):
        belief = Belief(rng)
        F, G = jacobians(jaw, belief)
        expected = model_step(jaw, belief.mean, belief.samples, belief.trend)
        state = belief.mean[STATE].copy()
        muscles = np.exp(belief.mean[PARAMETERS]).reshape(6, 2)
        propagate(jaw, muscles, state, belief.samples, belief.trend, belief.mean[GAIN], DT, scratch)
        np.testing.assert_allclose(state, expected, rtol=1e-10, atol=1e-12)
        total = np.hstack([F[STATE], G[STATE]])
        for rows in (slice(0, 2), slice(2, 5), slice(5, 7), slice(7, 10)):
            for columns in (
                slice(0, 2), slice(2, 5), slice(5, 7), slice(7, 10), PARAMETERS, GAIN, slice(23, 29), slice(29, 35)
            ):  # fmt: skip
                wrong = np.abs(scratch["total"][rows, columns] - total[rows, columns]).max()
                assert wrong <= 1e-8 * np.abs(total[rows, columns]).max()


def test_the_jacobian_where_stops_are_pressed_and_the_step_is_divided(jaw, rng, scratch):
    """Both models divide the step alike; the derivative goes through teeth and capsule."""
    divisions = set()
    for _ in range(30):
        belief = Belief(rng)
        belief.mean[0] = rng.choice([-0.7e-3, -0.2e-3, jaw["crest"] + 0.3e-3])
        belief.mean[2] = rng.uniform(-0.02, 0.005)
        muscles = np.exp(belief.mean[PARAMETERS]).reshape(6, 2)
        rate = independent_rate(jaw, belief.mean[PARAMETERS], belief.mean[:5])
        assert rate == pytest.approx(fastest_rate(jaw, muscles, tuple(belief.mean[:5])), rel=1e-10)
        parts = parts_needed(rate, DT, 1)
        assert independent_parts(rate, DT) == parts
        divisions.add(parts)
        expected, total = step_with_derivative(jaw, belief.mean, belief.samples, belief.trend, DT)
        state = belief.mean[STATE].copy()
        propagate(jaw, muscles, state, belief.samples, belief.trend, belief.mean[GAIN], DT, scratch)
        np.testing.assert_allclose(state, expected, rtol=1e-10, atol=1e-12)
        unit = np.abs(total).max(axis=0)
        assert (np.abs(scratch["total"] - total) / unit).max() < 1e-9
    assert len(divisions) > 1


def test_noise_of_three_samples_acts_as_a_constant_and_a_tilting_one(jaw, rng):
    """Each with the variance of the samples' mean: on the teeth, where a constant one alone is far off."""
    wrong, without = [], []
    for _ in range(10):
        belief = Belief(rng)
        belief.mean[0], belief.mean[2] = rng.uniform(0.0, 1e-3), rng.uniform(-0.02, -0.005)

        def moved(values, belief=belief):
            return model_step(jaw, belief.mean, values.reshape(values.shape[:-1] + (3, 6)), belief.trend)

        by_samples = twin.derivative(moved, belief.samples.ravel())
        _, G = jacobians(jaw, belief)
        variance = np.repeat([2.4e-3, 1e-6], 3)
        exact = by_samples @ np.diag(np.tile(2.0 * variance, 3)) @ by_samples.T
        constant = G[STATE, :6] @ np.diag(variance) @ G[STATE, :6].T
        sd = np.sqrt(np.diag(exact))
        both = constant + G[STATE, 6:] @ np.diag(variance) @ G[STATE, 6:].T
        wrong.append(np.abs((both - exact) / np.outer(sd, sd)).max())
        without.append(np.abs((constant - exact) / np.outer(sd, sd)).max())
    assert max(wrong) < 0.22
    assert max(without) > 0.6


def test_a_step_is_divided_at_the_same_rates():
    for rate in np.concatenate([np.linspace(0.0, 3e3, 301), 150.0 * np.arange(1, 18) * (1 + 1e-9)]):
        assert independent_parts(rate, DT) == parts_needed(rate, DT, 1)


def test_measurements_and_their_rows(jaw, rng):
    for _ in range(20):
        state = Belief(rng).mean[STATE].copy()
        rows, expected = np.empty((12, 10)), np.empty(12)
        measure(jaw, state, rows, expected)
        np.testing.assert_allclose(expected, twin.measurement(jaw, state), rtol=1e-12, atol=1e-15)
        by_state = twin.derivative(lambda s: twin.measurement(jaw, s), state)
        np.testing.assert_allclose(rows, by_state, rtol=1e-12, atol=1e-14)


def test_the_trend_follows_the_readings():
    trend, samples = np.zeros(6), np.tile(np.arange(1.0, 7.0), (3, 1))
    for _ in range(round(TREND_TIME / DT)):
        follow_trend(trend, samples, DT)
    np.testing.assert_allclose(trend, (1 - np.exp(-1)) * samples[0], rtol=1e-12)
