"""The bounds against a linear Gaussian experiment, whose information is known."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import jawenv
from jawenv.inference.information_gain import contrastive_bounds

# Readings A theta + noise of unit variance, theta standard normal.
A = np.array([[1.5, 0.2], [-0.4, 1.0], [0.6, 0.6]])
POSTERIOR_COV = np.linalg.inv(np.eye(2) + A.T @ A)
INFORMATION = 0.5 * np.linalg.slogdet(np.eye(3) + A @ A.T)[1]
PRIOR = multivariate_normal(np.zeros(2))


def experiments(n, rng):
    """True parameters (n, 2), readings (n, 3)."""
    theta = rng.normal(size=(n, 2))
    return theta, theta @ A.T + rng.normal(size=(n, 3))


def linear_likelihood(readings, theta):
    """(..., L) of readings (..., 3) at (..., L, 2)."""
    return -0.5 * ((readings[..., None, :] - theta @ A.T) ** 2).sum(axis=-1) - 1.5 * np.log(2.0 * np.pi)


def near(values, expected):
    return abs(values.mean() - expected) < 4.0 * values.std() / np.sqrt(len(values))


def test_contrasts_from_the_prior_bound_the_information_of_a_linear_experiment():
    rng = np.random.default_rng(0)
    truth, readings = experiments(3000, rng)
    gaps = []
    for contrasts in (3, 30, 1000):
        theta = np.concatenate([truth[:, None], rng.normal(size=(3000, contrasts, 2))], axis=1)
        lower, upper = contrastive_bounds(linear_likelihood(readings, theta))
        error = 4.0 * lower.std() / np.sqrt(3000)
        assert lower.mean() - error < INFORMATION < upper.mean() + error
        assert lower.max() <= np.log(contrasts + 1)
        gaps.append(upper.mean() - lower.mean())
    assert gaps[0] > 5.0 * gaps[1] > 25.0 * gaps[2] and gaps[2] < 0.01
    assert near(lower, INFORMATION)


def test_contrasts_from_the_posterior_give_the_information_at_once():
    rng = np.random.default_rng(1)
    truth, readings = experiments(2000, rng)
    mean = readings @ A @ POSTERIOR_COV
    theta = mean[:, None] + rng.multivariate_normal(np.zeros(2), POSTERIOR_COV, (2000, 2))
    theta[:, 0] = truth
    proposal = multivariate_normal(np.zeros(2), POSTERIOR_COV).logpdf(theta - mean[:, None])
    lower, upper = contrastive_bounds(linear_likelihood(readings, theta), PRIOR.logpdf(theta) - proposal)
    np.testing.assert_allclose(lower, upper, atol=1e-9)
    np.testing.assert_allclose(lower, proposal[:, 0] - PRIOR.logpdf(truth), atol=1e-9)
    assert near(lower, INFORMATION)


def test_the_lower_bound_is_one_for_a_wrong_likelihood_too():
    rng = np.random.default_rng(2)
    truth, readings = experiments(3000, rng)
    theta = np.concatenate([truth[:, None], rng.normal(size=(3000, 200, 2))], axis=1)
    for wrong in (4.0, 0.25):
        lower, upper = contrastive_bounds(wrong * linear_likelihood(readings, theta))
        assert lower.mean() < INFORMATION
    assert upper.mean() < INFORMATION  # which is no bound here


def test_what_is_refused():
    for values, weights in ((np.zeros(3), None), (np.zeros((2, 1)), None), (np.zeros((2, 3)), np.zeros((2, 2)))):
        with pytest.raises(jawenv.InputError):
            jawenv.contrastive_bounds(values, weights)
    with pytest.raises(jawenv.InputError):
        contrastive_bounds([[0.0, np.nan]])
