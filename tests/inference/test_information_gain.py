"""The bounds against a linear Gaussian experiment, whose information is known, and against a grid."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from test_patient_law import HINGE

import jawenv
from jawenv.inference import information_gain as module
from jawenv.inference.information_gain import contrastive_bounds, information_gain
from jawenv.inference.patient_law import PatientLaw

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


def test_a_record_of_the_linear_experiment(monkeypatch):
    """Barber and Agakov's bound of the true posterior is the information, and lower by the divergence of another"""
    law = SimpleNamespace(log_density=PRIOR.logpdf, entropy=float(PRIOR.entropy()))
    law.log_density = lambda theta: np.atleast_1d(PRIOR.logpdf(theta))
    monkeypatch.setattr(module, "log_likelihood", lambda record, theta: linear_likelihood(record.readings, theta))
    truth, readings = experiments(400, np.random.default_rng(3))
    made = {1.0: [], 2.0: []}
    for scale, gains in made.items():
        for i in range(400):
            record = SimpleNamespace(truth=truth[i], readings=readings[i])
            mean = readings[i] @ A @ POSTERIOR_COV
            gains.append(information_gain(record, law, mean, scale * POSTERIOR_COV, contrasts=200, seed=i))
    for gains in made.values():
        lower, upper = (np.array([getattr(gain, name) for gain in gains]) for name in ("lower", "upper"))
        assert near(lower, INFORMATION) and near(upper, INFORMATION) and (upper - lower).mean() < 0.01
    right, wide = (np.array([gain.posterior for gain in gains]) for gains in made.values())
    assert near(right, INFORMATION)
    assert near(right - wide, np.log(2.0) - 0.5)  # divergence of two normal laws
    assert 120 < np.mean([gain.effective for gain in made[1.0]]) < 200


@pytest.fixture(scope="module")
def opened():
    """A hinge's record of 1 s, and the law of its patient."""
    law = PatientLaw.of(env_id=HINGE, draws=500)
    actions = np.outer(np.linspace(0.0, 0.4, 20), [1.0, 1.0, 0.0, 0.0])
    made = jawenv.simulate(law.sample(1, 0), actions, 0, env_id=HINGE, env_kwargs={"control": "force"})
    return made.records[0], law


def test_a_hinge_against_a_grid(opened):
    record, law = opened
    aside = np.linspace(-0.1, 0.1, 50)  # the sds are 0.010 and 0.015
    theta = record.truth + np.stack(np.meshgrid(aside, aside, indexing="ij"), axis=-1).reshape(-1, 2)
    volume = (aside[1] - aside[0]) ** 2
    joint = jawenv.log_likelihood(record, theta) + law.log_density(theta)
    weight = np.exp(joint - joint.max())
    assert weight[np.abs(theta - record.truth).max(axis=1) > 0.09].sum() < 1e-6 * weight.sum(), "all is on the grid"
    evidence = joint.max() + np.log(weight.sum() * volume)
    exact = float(jawenv.log_likelihood(record, record.truth)) - evidence
    mean = weight @ theta / weight.sum()
    cov = np.cov(theta.T, aweights=weight)
    gain = jawenv.information_gain(record, law, mean, cov, contrasts=300)
    assert gain.lower == pytest.approx(exact, abs=0.1) and gain.upper == pytest.approx(exact, abs=0.1)
    assert gain.posterior == pytest.approx(exact, abs=1.0) and gain.effective > 100
    assert gain == jawenv.information_gain(record, law, mean, cov, contrasts=300)
    alone = jawenv.information_gain(record, law, mean, cov, contrasts=0)
    assert alone.posterior == gain.posterior and np.isnan([alone.lower, alone.upper]).all()


def test_what_is_refused(opened):
    record, law = opened
    mean, cov = record.truth, 0.01 * np.eye(2)
    with pytest.raises(jawenv.InputError):
        information_gain(replace(record, truth=None), law, mean, cov)
    with pytest.raises(jawenv.InputError):
        information_gain(replace(record, truth=record.truth + 5.0), law, mean, cov)
    for wrong in (-cov, np.eye(3), np.full((2, 2), np.nan)):
        with pytest.raises(jawenv.InputError):
            information_gain(record, law, mean, wrong)
    with pytest.raises(jawenv.InputError):
        information_gain(record, law, mean, cov, contrasts=-1)
    for values, weights in ((np.zeros(3), None), (np.zeros((2, 1)), None), (np.zeros((2, 3)), np.zeros((2, 2)))):
        with pytest.raises(jawenv.InputError):
            contrastive_bounds(values, weights)
    with pytest.raises(jawenv.InputError):
        contrastive_bounds([[0.0, np.nan]])
