"""One step of the joint Kalman recursion against dense textbook matrices, with an independent model."""

import newton_euler as twin
import numpy as np
import pytest
from joint_belief import DT, GAIN, STATE, Belief, jacobians, model_step

from jawenv.filter.bound.joint_recursion import innovation_variance, joint_scratch_dtype
from jawenv.references.extended_kalman_kernel import Problem, predict_plain, update_plain

NOISE_VARIANCE = np.repeat([0.012, 1e-5, 2.4e-3, 1e-6], 3)
VARIANCES = np.repeat([1e-4, 1.7e-3, 1e-3, 2e-2], 3) ** 2
ALL = np.ones(12, dtype=np.uint8)
POINT = np.tile(np.repeat([1, 0], 3), 2).astype(np.uint8)


@pytest.fixture
def scratch():
    return np.zeros(1, dtype=joint_scratch_dtype())[0]


def run_predict(jaw, belief, scratch, noise=0.0):
    mean, covariance = belief.mean.copy(), belief.covariance.copy()
    problem = Problem(
        jaw=jaw,
        measured=np.empty((2, 12)),
        samples=belief.samples[None],
        dt=DT,
        variances=np.ones(12),
        noise_variance=NOISE_VARIANCE,
        parameter_noise=np.full((1, 12), noise),
        linear=False,
        floor=np.zeros(12),
    )
    predict_plain(problem, 0, mean, covariance, belief.trend, scratch)
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
