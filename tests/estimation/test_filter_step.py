"""One step of the joint Kalman recursion against dense textbook matrices, with an independent model."""

import newton_euler as twin
import numpy as np
import pytest

import jawenv
from jawenv.estimation.model.encoders import measure
from jawenv.estimation.model.load_cell import TREND_TIME, follow_trend
from jawenv.estimation.model.step import propagate
from jawenv.estimation.references.extended_kalman_kernel import predict_plain, update_plain
from jawenv.estimation.references.joint_recursion import innovation_variance, joint_scratch_dtype, parameter_variance
from jawenv.estimation.references.numpy_model import fastest_rate as independent_rate
from jawenv.estimation.references.numpy_model import parts_needed as independent_parts
from jawenv.estimation.references.numpy_model import step, step_with_derivative
from jawenv.mechanics.stiffness import fastest_rate, parts_needed

DT = 0.01
STATE, PARAMETERS, GAIN = slice(0, 10), slice(10, 22), 22
NOISE_VARIANCE = np.repeat([0.012, 1e-5, 2.4e-3, 1e-6], 3)
VARIANCES = np.repeat([1e-4, 1.7e-3, 1e-3, 2e-2], 3) ** 2
ALL = np.ones(12, dtype=np.uint8)
POINT = np.tile(np.repeat([1, 0], 3), 2).astype(np.uint8)
# Of the states (m, rad, m/s, rad/s), parameters and gain, as after some seconds of measurement.
SD = np.concatenate([[1e-4, 1e-4], [2e-3] * 3, [1e-3] * 2, [1e-2] * 3, [0.3] * 12, [0.01]])


@pytest.fixture
def scratch():
    return np.zeros(1, dtype=joint_scratch_dtype())[0]


class Belief:
    """A random mean and correlated covariance of a moving jaw, with load-cell samples and their trend."""

    def __init__(self, rng, gain_sd=0.01, parameter_sd=0.3):
        motion = [
            rng.uniform(1e-3, 8e-3),
            rng.uniform(-1e-3, 1e-3),
            rng.uniform(0.1, 0.4),
            *rng.uniform(-0.05, 0.05, 2),
        ]
        motion += [*rng.uniform(-0.02, 0.02, 2), *rng.uniform(-0.5, 0.5, 3)]
        parameters = jawenv.cohort("trismus").draw_log_parameters(rng)
        self.mean = np.concatenate([motion, parameters, [rng.normal() * gain_sd]])
        sd = SD.copy()
        sd[PARAMETERS], sd[GAIN] = parameter_sd, gain_sd
        factor = rng.normal(size=(23, 40))
        correlation = factor @ factor.T
        scale = sd / np.sqrt(np.diag(correlation))
        self.covariance = correlation * np.outer(scale, scale)
        self.covariance = 0.5 * (self.covariance + self.covariance.T)
        self.trend = np.concatenate([rng.uniform(-8, 8, 3), rng.uniform(-0.1, 0.1, 3)])
        self.samples = self.trend + rng.normal(size=(3, 6)) * [0.5, 0.5, 0.5, 0.02, 0.02, 0.02]


def model_step(jaw, mean, samples, trend, wrench=None):
    """The independent step of the ten states; complex-safe."""
    return step(jaw, mean, samples, trend, DT, wrench)


def jacobians(jaw, belief):
    """Dense F (23, 23) and G (23, 12)."""
    _, by_all = step_with_derivative(jaw, belief.mean, belief.samples, belief.trend, DT)
    F, G = np.eye(23), np.zeros((23, 12))
    F[STATE], G[STATE] = by_all[:, :23], by_all[:, 23:]
    return F, G


def run_predict(jaw, belief, scratch, noise=0.0):
    mean, covariance = belief.mean.copy(), belief.covariance.copy()
    predict_plain(
        jaw, mean, covariance, belief.samples, belief.trend, DT, NOISE_VARIANCE, np.full(12, noise),
        False, np.zeros(12), np.empty(12), scratch,
    )  # fmt: skip
    return mean, covariance


def assert_same_covariance(actual, expected, relative=1e-9):
    """Equal relative to the standard deviations: P spans ten orders of magnitude."""
    sd = np.sqrt(np.diag(expected))
    sd[sd == 0.0] = 1.0
    assert np.abs((actual - expected) / np.outer(sd, sd)).max() < relative
    np.testing.assert_array_equal(actual, actual.T)


def assert_same_mean(actual, expected, covariance, relative=1e-9):
    sd = np.sqrt(np.diag(covariance))
    sd[sd == 0.0] = 1.0
    assert np.abs((actual - expected) / sd).max() < relative


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
    assert max(wrong) < 0.2
    assert max(without) > 0.6


def test_a_step_is_divided_at_the_same_rates():
    for rate in np.concatenate([np.linspace(0.0, 3e3, 301), 150.0 * 2.0 ** np.arange(6) * (1 + 1e-9)]):
        assert independent_parts(rate, DT) == parts_needed(rate, DT, 1)


def test_measurements_and_their_rows(jaw, rng):
    for _ in range(20):
        state = Belief(rng).mean[STATE].copy()
        rows, expected = np.empty((12, 10)), np.empty(12)
        measure(jaw, state, rows, expected)
        np.testing.assert_allclose(expected, twin.measurement(jaw, state), rtol=1e-12, atol=1e-15)
        by_state = twin.derivative(lambda s: twin.measurement(jaw, s), state)
        np.testing.assert_allclose(rows, by_state, rtol=1e-12, atol=1e-14)


def fast_reading(belief):
    """What the mean reading of the step departs from its trend; the gain error's share of it is process noise."""
    return np.array([1.0, 4.0, 1.0]) @ belief.samples / 6.0 - belief.trend


def test_prediction_is_the_dense_one(jaw, rng, scratch):
    """F P F^T + G W G^T + Q, with the share of the gain error in what the trend does not follow."""
    for _ in range(10):
        belief, noise = Belief(rng), 1e-5
        mean, covariance = run_predict(jaw, belief, scratch, noise)
        F, G = jacobians(jaw, belief)
        moved = model_step(jaw, belief.mean, belief.samples, belief.trend)
        Q = np.diag(np.concatenate([np.zeros(10), np.full(12, noise), [0.0]]))
        W = np.diag(NOISE_VARIANCE)
        W[:6, :6] += np.diag(belief.covariance[GAIN, GAIN] * fast_reading(belief) ** 2)
        expected = F @ belief.covariance @ F.T + G @ W @ G.T + Q
        assert_same_mean(mean, np.concatenate([moved, belief.mean[10:]]), expected)
        assert_same_covariance(covariance, expected)


@pytest.mark.parametrize("used", [ALL, POINT], ids=["pose", "point"])
def test_the_update_considers_the_gain_as_schmidt_does(jaw, rng, scratch, used):
    """The optimal gain without its last row, and Joseph's form, which holds for any gain."""
    chosen = used.astype(bool)
    for _ in range(10):
        belief = Belief(rng)
        H = np.hstack([twin.derivative(lambda s: twin.measurement(jaw, s), belief.mean[STATE]), np.zeros((12, 13))])
        H, R = H[chosen], np.diag(VARIANCES[chosen])
        expected = twin.measurement(jaw, belief.mean[STATE])
        measured = expected + 3.0 * np.sqrt(VARIANCES) * rng.normal(size=12)
        K = belief.covariance @ H.T @ np.linalg.inv(H @ belief.covariance @ H.T + R)
        K[GAIN] = 0.0
        rest = np.eye(23) - K @ H
        P = rest @ belief.covariance @ rest.T + K @ R @ K.T
        mean, covariance = belief.mean.copy(), belief.covariance.copy()
        update_plain(jaw, mean, covariance, np.where(chosen, measured, np.nan), VARIANCES, scratch)
        assert_same_mean(mean, belief.mean + K @ (measured - expected)[chosen], P)
        assert_same_covariance(covariance, P)
        assert mean[GAIN] == belief.mean[GAIN]
        assert covariance[GAIN, GAIN] == belief.covariance[GAIN, GAIN]


def test_one_measurement_reports_the_variance_of_its_innovation(jaw, rng):
    belief, row, gain = Belief(rng), rng.normal(size=10), np.empty(23)
    covariance = belief.covariance.copy()
    variance = innovation_variance(covariance, row, 1e-6, gain)
    assert variance == pytest.approx(row @ belief.covariance[STATE, STATE] @ row + 1e-6, rel=1e-12)
    np.testing.assert_allclose(gain, belief.covariance[:, STATE] @ row, rtol=1e-10)


def test_the_parameters_noise_decays_and_does_not_depend_on_the_step():
    rate, time_constant = 0.035, 5.0
    halves = parameter_variance(rate, time_constant, 1.0, 0.5) + parameter_variance(rate, time_constant, 1.5, 0.5)
    assert parameter_variance(rate, time_constant, 1.0, 1.0) == pytest.approx(halves, rel=1e-12)
    assert parameter_variance(rate, time_constant, 0.0, 1e-6) == pytest.approx(rate**2 * 1e-6, rel=1e-5)
    after = parameter_variance(rate, time_constant, time_constant, 1e-6)
    assert np.sqrt(after / 1e-6) == pytest.approx(rate / np.e, rel=1e-5)


def test_the_trend_follows_the_readings():
    trend, samples = np.zeros(6), np.tile(np.arange(1.0, 7.0), (3, 1))
    for _ in range(round(TREND_TIME / DT)):
        follow_trend(trend, samples, DT)
    np.testing.assert_allclose(trend, (1 - np.exp(-1)) * samples[0], rtol=1e-12)
