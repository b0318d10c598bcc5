"""The linearised method and its bias, and the nonlinear one, against pseudo-inverses of their own."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import pytest
from estimation_records import quiet_records, records

from eval.thesis.methods import moment_balance
from eval.thesis.methods.least_squares import exerted, exerted_jacobian, linear, nonlinear
from eval.thesis.methods.moment_balance import Balance, balance_of
from jawenv.anatomy import Prior
from jawenv.mechanics import build_jaw

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
    return Balance(needed, np.eye(3), pull, strain, np.arange(6))


def test_the_linear_method_is_a_pseudo_inverse_and_its_bias_is_that_of_the_expansion(rng):
    """Eq. 5.10 by hand. Without any noise it returns other numbers than F_o and F_o b, and these."""
    balance = twin_balance(rng)
    G = np.zeros((60 * 3, 12))
    for i in range(6):
        G[:, 2 * i] = balance.pull[:, i].ravel()
        G[:, 2 * i + 1] = (balance.pull[:, i] * balance.strain[:, i, None]).ravel()
    found = linear(balance)
    np.testing.assert_allclose(found, np.linalg.pinv(G) @ balance.needed.ravel(), rtol=1e-7)
    F_o, b = np.exp(TRUTH[0::2]), np.exp(TRUTH[1::2])
    wanted = np.column_stack([F_o, F_o * b]).ravel()
    curvature = np.einsum("nl,nlr->nr", F_o * (np.exp(b * balance.strain) - 1.0 - b * balance.strain), balance.pull)
    np.testing.assert_allclose(found - wanted, np.linalg.pinv(G) @ curvature.ravel(), rtol=1e-6)
    assert np.abs(found / wanted - 1.0).max() > 0.2


def test_the_linear_method_is_right_where_the_law_is_linear(rng):
    balance = twin_balance(rng)
    F_o, b = np.exp(TRUTH[0::2]), np.exp(TRUTH[1::2])
    straight = replace(balance, needed=np.einsum("nl,nlr->nr", F_o * (1.0 + b * balance.strain), balance.pull))
    found = linear(straight)
    np.testing.assert_allclose(found, np.column_stack([F_o, F_o * b]).ravel(), atol=1e-7)


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
def test_the_nonlinear_method_recovers_the_truth_without_noise_and_the_linear_one_does_not(model, monkeypatch):
    """What is left of the error is the curvature within ticks and windows, which are short here."""
    monkeypatch.setattr(moment_balance, "SMOOTHING_S", 0.05)
    for record in quiet_records(model):
        np.testing.assert_allclose(nonlinear(record, 2), record.truth, atol=2e-3)
        force, slope = linear(balance_of(record)).reshape(-1, 2).T
        assert not np.abs(slope / force / np.exp(record.truth[1::2]) - 1.0).max() < 0.2


def test_from_more_starts_the_same_minimum():
    record = quiet_records("Jaw")[0]
    np.testing.assert_allclose(nonlinear(record, 1), nonlinear(record, 4), atol=1e-5)


@pytest.mark.parametrize("model", ["JawHinge", "Jaw"])
def test_with_noise_it_is_near_the_truth(model):
    error = np.array([nonlinear(record, 1) - record.truth for record in records(model)])
    assert np.sqrt(np.mean(error**2)) < 0.06


def test_a_slow_opening_leaves_parallel_muscles_unseparated():
    """Errors of the condyle's place are errors of the regressors."""
    error = np.array([nonlinear(record, 1) - record.truth for record in records("Jaw", "slow_opening")])
    assert np.abs(error[:, 4]).mean() > 0.15, "medial pterygoid"
    assert np.abs(error[:, 2]).mean() < 0.15, "temporalis"


def test_the_prior_counts_only_when_asked_for():
    record = records("JawHinge")[0]
    strict = replace(record, prior=Prior(record.truth + 0.5, np.full(2, 0.11)))
    free, held = (nonlinear(strict, use_prior=use) for use in (False, True))
    np.testing.assert_allclose(free, record.truth, atol=0.03)
    surer = replace(record, prior=Prior(record.truth + 0.5, np.full(2, 0.101)))
    assert (np.abs(held - record.truth) > np.abs(free - record.truth)).all()
    np.testing.assert_allclose(nonlinear(surer), free, atol=1e-3)
