"""The linearised method and its bias, the nonlinear one and its honesty, against pseudo-inverses of their own."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import pytest
from estimation_records import quiet_records, records
from hypothesis import given, settings
from hypothesis import strategies as some

from eval.thesis.methods.least_squares import (
    LinearLeastSquares,
    NonlinearLeastSquares,
    exerted,
    exerted_jacobian,
)
from eval.thesis.methods.moment_balance import Balance, balance_of
from eval.thesis.methods.regression import regression_covariance
from jawenv.anatomy import Prior
from jawenv.mechanics import build_jaw
from jawenv.metrics.calibration import nees

TRUTH = np.array([0.3, 1.8, 0.2, 1.7, 0.3, 2.2, 0.9, 2.0, 0.3, 1.8, 0.4, 2.3])


def poses(rng, number):
    return rng.uniform([5e-4, -3e-3, 0.05, -0.1, -0.1], [1.2e-2, 3e-3, 0.4, 0.1, 0.1], (number, 5))


def twin_balance(rng, number=60):
    """The moments that the independent model's muscles exert in random poses, in rows of unit noise."""
    jaw = build_jaw()
    pull, strain = np.empty((number, 6, 3)), np.empty((number, 6))
    for n, q in enumerate(poses(rng, number)):
        R, contact = twin.rotation(q), twin.contact(jaw, q)
        arms = jaw["insertion"] @ R.T
        lines = jaw["origin"] - contact - arms
        pull[n] = np.cross(arms, lines / np.linalg.norm(lines, axis=1)[:, None]) @ R
        strain[n] = np.linalg.norm(lines, axis=1) / jaw["l_o"] - 1.0
    F_o, b = np.exp(TRUTH[0::2]), np.exp(TRUTH[1::2])
    needed = np.einsum("nl,nlr->nr", F_o * np.exp(b * strain), pull)
    return Balance(needed, 0.01 * needed, np.eye(3), pull, strain, np.arange(6))


def test_the_linear_method_is_a_pseudo_inverse_and_its_bias_is_that_of_the_expansion(rng):
    """Eq. 5.10 by hand. Without any noise it returns other numbers than F_o and F_o b, and these."""
    balance = twin_balance(rng)
    G = np.zeros((60 * 3, 12))
    for i in range(6):
        G[:, 2 * i] = balance.pull[:, i].ravel()
        G[:, 2 * i + 1] = (balance.pull[:, i] * balance.strain[:, i, None]).ravel()
    found, _ = LinearLeastSquares().coefficients(balance)
    np.testing.assert_allclose(found, np.linalg.pinv(G) @ balance.needed.ravel(), rtol=1e-7)
    F_o, b = np.exp(TRUTH[0::2]), np.exp(TRUTH[1::2])
    wanted = np.column_stack([F_o, F_o * b]).ravel()
    curvature = np.einsum("nl,nlr->nr", F_o * (np.exp(b * balance.strain) - 1.0 - b * balance.strain), balance.pull)
    np.testing.assert_allclose(found - wanted, np.linalg.pinv(G) @ curvature.ravel(), rtol=1e-6)
    assert np.abs(found / wanted - 1.0).max() > 0.2


def test_the_linear_method_is_right_where_the_law_is_linear(rng):
    balance = twin_balance(rng)
    F_o, b = np.exp(TRUTH[0::2]), np.exp(TRUTH[1::2])
    linear = replace(balance, needed=np.einsum("nl,nlr->nr", F_o * (1.0 + b * balance.strain), balance.pull))
    found, _ = LinearLeastSquares().coefficients(linear)
    np.testing.assert_allclose(found, np.column_stack([F_o, F_o * b]).ravel(), atol=1e-7)


def test_the_linear_methods_covariance_is_that_of_many_draws(rng):
    balance = twin_balance(rng, 200)
    F_o, b = np.exp(TRUTH[0::2]), np.exp(TRUTH[1::2])
    clean = np.einsum("nl,nlr->nr", F_o * (1.0 + b * balance.strain), balance.pull)
    found, claimed = [], []
    for _ in range(300):
        noisy = replace(balance, needed=clean + 1e-4 * rng.standard_normal(clean.shape))
        coefficients, covariance = LinearLeastSquares().coefficients(noisy)
        found.append(coefficients)
        claimed.append(np.diag(covariance))
    np.testing.assert_allclose(np.mean(claimed, axis=0), np.var(found, axis=0), rtol=0.35)


def test_the_jacobian_by_the_log_parameters(rng):
    """With two lines of one muscle among them."""
    balance = replace(twin_balance(rng, 5), muscle=np.array([0, 0, 1, 2, 2, 1]))
    parameters = TRUTH[:6]
    step = 1e-6
    difference = [
        (exerted(balance, parameters + change) - exerted(balance, parameters - change)) / (2 * step)
        for change in step * np.eye(6)
    ]
    np.testing.assert_allclose(exerted_jacobian(balance, parameters), np.stack(difference, axis=2), atol=1e-8)


@pytest.mark.parametrize("model", ["Jaw", "JawHinge"])
@pytest.mark.parametrize("rows", ["all", "moment"])
def test_the_nonlinear_method_recovers_the_truth_without_noise_and_the_linear_one_does_not(model, rows):
    """What is left of the error is the curvature within ticks and windows."""
    for record in quiet_records(model):
        found = NonlinearLeastSquares(rows, starts=2, smoothing_s=0.05).estimate(record)
        np.testing.assert_array_equal(found.time, record.time[-1:])
        np.testing.assert_allclose(found.mean[0], record.truth, atol=2e-3)
        force, slope = (
            LinearLeastSquares().coefficients(balance_of(record, rows=rows, smoothing_s=0.05))[0].reshape(-1, 2).T
        )
        assert not np.abs(slope / force / np.exp(record.truth[1::2]) - 1.0).max() < 0.2


def test_from_other_starts_the_same_minimum():
    record = quiet_records("Jaw")[0]
    one, other = (NonlinearLeastSquares(starts=starts, seed=seed).estimate(record) for starts, seed in ((1, 0), (4, 9)))
    np.testing.assert_allclose(one.mean, other.mean, atol=1e-5)


# Of 16 patients (seeds from 10,000): hinge NEES 1.6 of 2, jaw 17 of 12.
@pytest.mark.parametrize(("model", "low", "high"), [("JawHinge", 0.2, 5.0), ("Jaw", 5.0, 40.0)])
def test_with_noise_it_is_near_the_truth_and_nearly_knows_how_near(model, low, high):
    played = records(model)
    found = [NonlinearLeastSquares(starts=1).estimate(record) for record in played]
    error = np.array([one.mean[0] - record.truth for one, record in zip(found, played, strict=True)])
    assert np.sqrt(np.mean(error**2)) < 0.06
    assert low < nees(error, np.array([one.cov[0] for one in found])).mean() < high


def test_a_slow_opening_leaves_parallel_muscles_unseparated_and_the_method_does_not_know():
    """Errors of the condyle's place are errors of the regressors, which the residuals' covariance does not show."""
    played = records("Jaw", "slow_opening")
    found = [NonlinearLeastSquares(starts=1).estimate(record) for record in played]
    error = np.array([one.mean[0] - record.truth for one, record in zip(found, played, strict=True)])
    assert np.abs(error[:, 4]).mean() > 0.15, "medial pterygoid"
    assert np.abs(error[:, 2]).mean() < 0.15, "temporalis"
    assert nees(error, np.array([one.cov[0] for one in found])).mean() > 60.0


def test_the_prior_counts_only_when_asked_for():
    record = records("JawHinge")[0]
    strict = replace(record, prior=Prior(record.truth + 0.5, np.full(2, 0.11)))
    free, held = (NonlinearLeastSquares(use_prior=use).estimate(strict) for use in (False, True))
    np.testing.assert_allclose(free.mean[0], record.truth, atol=0.03)
    surer = replace(record, prior=Prior(record.truth + 0.5, np.full(2, 0.101)))
    assert (np.abs(held.mean[0] - record.truth) > np.abs(free.mean[0] - record.truth)).all()
    assert (np.diag(held.cov[0]) < np.diag(free.cov[0])).all()
    np.testing.assert_allclose(NonlinearLeastSquares().estimate(surer).mean, free.mean, atol=1e-3)


@settings(max_examples=25, deadline=None)
@given(gain_sd=some.floats(0.0, 0.1), seed=some.integers(0, 1000), run=some.sampled_from([1, 2, 4]))
def test_covariance_of_a_regression(gain_sd, seed, run):
    """Against textbook matrices: noise that is the same for ``run`` times, and a gain error shared by all."""
    rng = np.random.default_rng(seed)
    time = np.arange(6000)
    slow = np.column_stack([np.ones(6000), np.cos(0.01 * time), np.sin(0.013 * time)])
    jacobian, by_gain = np.stack([slow, 2.0 * slow[:, ::-1]], axis=1), rng.normal(size=(6000, 2))
    by_gain += jacobian @ [1.0, -0.5, 0.2]
    residual = np.repeat(0.3 * rng.standard_normal((6000 // run, 2)), run, axis=0)
    flat = jacobian.reshape(-1, 3)
    inverse = np.linalg.inv(flat.T @ flat)
    shift = inverse @ flat.T @ by_gain.ravel()
    # Regressors hardly change in a run; Bartlett's weight of a lag is 1 - lag / 5.
    inflation = 1.0 + 2.0 * sum((1.0 - lag / 5.0) * (1.0 - lag / run) for lag in range(1, run))
    expected = 0.09 * inflation * inverse + gain_sd**2 * np.outer(shift, shift)
    found = regression_covariance(jacobian, residual, by_gain, gain_sd)
    np.testing.assert_array_equal(found, found.T)
    scale = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.25)
