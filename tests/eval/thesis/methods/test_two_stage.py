"""The failed method: exact for one muscle, wrong for more, because the log of a sum is not the sum of logs."""

import numpy as np
import pytest
from estimation_records import quiet_records
from hypothesis import given
from hypothesis import strategies as some

from eval.thesis.methods.moment_balance import Balance
from eval.thesis.methods.two_stage import TwoStageLogLinear, constant_forces, small_opening


def made_balance(F_o, b, seed=0, number=40):
    """Muscles that pull in random directions with random strains; no noise."""
    rng = np.random.default_rng(seed)
    pull, strain = rng.normal(size=(number, len(F_o), 3)), rng.uniform(0.02, 0.3, (number, len(F_o)))
    needed = np.einsum("nl,nlr->nr", F_o * np.exp(b * strain), pull)
    return Balance(needed, np.zeros_like(needed), np.eye(3), pull, strain, np.arange(len(F_o)))


@given(F_o=some.floats(0.1, 10.0), b=some.floats(0.5, 15.0), seed=some.integers(0, 100))
def test_one_muscle_with_known_f_o_is_exact(F_o, b, seed):
    found, covariance = TwoStageLogLinear().exponents(made_balance([F_o], np.array([b]), seed), np.array([F_o]))
    np.testing.assert_allclose(found, [b], rtol=1e-9)
    assert covariance[0, 0] < 1e-12 * b * b


@pytest.mark.parametrize("b", [4.0, 6.0, 8.0])
def test_the_printed_product_is_wrong_even_for_one_muscle(b):
    """But by coincidence: of 30 random maneuvers a few come within a tenth."""
    off = [
        TwoStageLogLinear("product").exponents(made_balance([1.3], np.array([b]), seed), np.array([1.3]))[0][0] / b
        - 1.0
        for seed in range(30)
    ]
    assert np.mean(np.abs(off) > 0.1) > 0.8


@pytest.mark.parametrize("form", ["difference", "product"])
@pytest.mark.parametrize("muscles", [2, 6])
def test_more_muscles_are_wrong_though_all_f_o_are_known_and_nothing_is_noisy(form, muscles):
    errors = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        F_o, b = rng.uniform(0.5, 3.0, muscles), rng.uniform(4.0, 9.0, muscles)
        found, _ = TwoStageLogLinear(form).exponents(made_balance(F_o, b, seed), F_o)
        errors.append(np.abs(found / b - 1.0).max())
    assert np.min(errors) > 0.2


def test_the_cause_is_the_log_of_the_sum():
    """Give the second stage the sum of logs that it takes ln d for, and it is exact for six muscles."""
    rng = np.random.default_rng(3)
    F_o, b = rng.uniform(0.5, 3.0, 6), rng.uniform(4.0, 9.0, 6)
    balance = made_balance(F_o, b)
    magnitude = np.abs(balance.pull).prod(axis=1) * F_o.prod() * np.exp(balance.strain @ b)[:, None]
    sign = np.sign(balance.pull).prod(axis=1)
    pretended = Balance(sign * magnitude, balance.by_gain, balance.noise, balance.pull, balance.strain, balance.muscle)
    found, _ = TwoStageLogLinear().exponents(pretended, F_o)
    np.testing.assert_allclose(found, b, rtol=1e-9)


def test_stage_one_is_a_pseudo_inverse_and_takes_the_tension_for_f_o(rng):
    balance = made_balance(np.array([1.0, 2.0]), np.array([6.0, 8.0]))
    small = small_opening(balance, 0.25)
    assert small.sum() == 10
    assert np.abs(balance.strain[small]).max() <= np.abs(balance.strain[~small]).max(axis=1).min()
    found, _ = constant_forces(balance.select(small), 0.0)
    H = balance.pull[small].transpose(0, 2, 1).reshape(-1, 2)
    np.testing.assert_allclose(found, np.linalg.pinv(H) @ balance.needed[small].ravel(), rtol=1e-9)
    assert (found > [1.0, 2.0]).all(), "stretched muscles pull with more than F_o"


def test_on_episodes_it_serves_a_hinge_and_nothing_else():
    """The hinge's error is that of F_o at a strain that is small but not 0: they have opposite signs."""
    for record in quiet_records("JawHinge"):
        found = TwoStageLogLinear().estimate(record)
        error = found.mean[0] - record.truth
        assert np.abs(error).max() < 0.6 and np.isfinite(found.cov).all()
        assert error[0] * error[1] < 0.0
        printed = TwoStageLogLinear("product").estimate(record).mean[0] - record.truth
        assert not abs(printed[1]) < 1.0
    for record in quiet_records("Jaw"):
        found = TwoStageLogLinear(rows="all").estimate(record)
        error = found.mean[0] - record.truth
        assert not np.abs(error).max() < 1.0, "NaN, or off by a factor of e"
        np.testing.assert_array_equal(np.isnan(found.cov[0]).all(axis=0), np.isnan(error))


def test_the_covariance_carries_the_first_stages_over(rng):
    """b of one muscle is -1/strain times the log of F_o, so a doubtful F_o makes a doubtful b, anticorrelated."""
    record = quiet_records("JawHinge")[0]
    covariance = TwoStageLogLinear().estimate(record).cov[0]
    assert covariance[0, 1] < 0.0
    assert np.linalg.eigvalsh(covariance).min() > 0.0
