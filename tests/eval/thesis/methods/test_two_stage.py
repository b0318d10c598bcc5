"""The failed method: exact for one muscle, wrong for more, because the log of a sum is not the sum of logs."""

import numpy as np
import pytest
from estimation_records import quiet_records
from hypothesis import given
from hypothesis import strategies as some

from eval.thesis.methods.moment_balance import Balance
from eval.thesis.methods.two_stage import constant_forces, exponents, small_opening, two_stages


def made_balance(F_o, b, seed=0, number=40):
    """Muscles that pull in random directions with random strains; no noise."""
    rng = np.random.default_rng(seed)
    pull, strain = rng.normal(size=(number, len(F_o), 3)), rng.uniform(0.02, 0.3, (number, len(F_o)))
    needed = np.einsum("nl,nlr->nr", F_o * np.exp(b * strain), pull)
    return Balance(needed, np.eye(3), pull, strain, np.arange(len(F_o)))


@given(F_o=some.floats(0.1, 10.0), b=some.floats(0.5, 15.0), seed=some.integers(0, 100))
def test_one_muscle_with_known_f_o_is_exact(F_o, b, seed):
    found = exponents(made_balance([F_o], np.array([b]), seed), np.array([F_o]))
    np.testing.assert_allclose(found, [b], rtol=1e-9)


@pytest.mark.parametrize("muscles", [2, 6])
def test_more_muscles_are_wrong_though_all_f_o_are_known_and_nothing_is_noisy(muscles):
    errors = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        F_o, b = rng.uniform(0.5, 3.0, muscles), rng.uniform(4.0, 9.0, muscles)
        found = exponents(made_balance(F_o, b, seed), F_o)
        errors.append(np.abs(found / b - 1.0).max())
    assert np.min(errors) > 0.2


def test_the_cause_is_the_log_of_the_sum():
    """Give the second stage the sum of logs that it takes ln d for, and it is exact for six muscles."""
    rng = np.random.default_rng(3)
    F_o, b = rng.uniform(0.5, 3.0, 6), rng.uniform(4.0, 9.0, 6)
    balance = made_balance(F_o, b)
    magnitude = np.abs(balance.pull).prod(axis=1) * F_o.prod() * np.exp(balance.strain @ b)[:, None]
    sign = np.sign(balance.pull).prod(axis=1)
    pretended = Balance(sign * magnitude, balance.noise, balance.pull, balance.strain, balance.muscle)
    found = exponents(pretended, F_o)
    np.testing.assert_allclose(found, b, rtol=1e-9)


def test_stage_one_is_a_pseudo_inverse_and_takes_the_tension_for_f_o(rng):
    balance = made_balance(np.array([1.0, 2.0]), np.array([6.0, 8.0]))
    small = small_opening(balance, 0.25)
    assert small.sum() == 10
    assert np.abs(balance.strain[small]).max() <= np.abs(balance.strain[~small]).max(axis=1).min()
    found = constant_forces(balance.select(small))
    H = balance.pull[small].transpose(0, 2, 1).reshape(-1, 2)
    np.testing.assert_allclose(found, np.linalg.pinv(H) @ balance.needed[small].ravel(), rtol=1e-9)
    assert (found > [1.0, 2.0]).all(), "stretched muscles pull with more than F_o"


def test_on_episodes_it_serves_a_hinge_and_nothing_else():
    """The hinge's error is that of F_o at a strain that is small but not 0: they have opposite signs."""
    for record in quiet_records("JawHinge"):
        error = two_stages(record) - record.truth
        assert np.abs(error).max() < 0.6
        assert error[0] * error[1] < 0.0
    for record in quiet_records("Jaw"):
        error = two_stages(record) - record.truth
        assert not np.abs(error).max() < 1.0, "NaN, or off by a factor of e"
