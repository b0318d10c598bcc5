import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2, multivariate_normal

from jawenv.metrics import alarm_word, claimed_information, covered, log_density, nees, nees_band, true_information

seeds = st.integers(0, 2**32 - 1)


def draw(seed, size=5):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((size, size + 3))
    return rng.standard_normal(size), rng.standard_normal(size), root @ root.T / size, rng


def test_nees_by_hand():
    assert nees(np.array([1.0, 2.0]), np.diag([4.0, 16.0])) == pytest.approx(0.5)


@given(seeds)
def test_log_density_is_scipys(seed):
    truth, mean, cov, _ = draw(seed)
    np.testing.assert_allclose(log_density(truth, mean, cov), multivariate_normal.logpdf(truth, mean, cov), rtol=1e-8)


@given(seeds)
def test_true_information_is_the_log_ratio_of_the_densities(seed):
    truth, mean, cov, rng = draw(seed)
    prior_mean, prior_sd = rng.standard_normal(5), rng.uniform(0.5, 2.0, 5)
    expected = multivariate_normal.logpdf(truth, mean, cov) - multivariate_normal.logpdf(
        truth, prior_mean, np.diag(prior_sd**2)
    )
    np.testing.assert_allclose(true_information(truth, mean, cov, prior_mean, prior_sd), expected, rtol=1e-7, atol=1e-9)


@given(seeds)
def test_the_gap_is_half_the_difference_of_the_nees(seed):
    truth, mean, cov, rng = draw(seed)
    prior_mean, prior_sd = rng.standard_normal(5), rng.uniform(0.5, 2.0, 5)
    gap = claimed_information(cov, prior_sd) - true_information(truth, mean, cov, prior_mean, prior_sd)
    expected = 0.5 * (nees(mean - truth, cov) - nees(prior_mean - truth, np.diag(prior_sd**2)))
    np.testing.assert_allclose(gap, expected, rtol=1e-7, atol=1e-8)


def test_claimed_information_by_hand():
    assert claimed_information(np.diag([0.01, 0.04]), np.array([1.0, 1.0])) == pytest.approx(np.log(10.0) + np.log(5.0))
    assert claimed_information(np.diag([0.25]), np.array([0.5])) == pytest.approx(0.0)


def test_nees_band_is_the_chi_squared_interval_of_the_mean():
    low, high = nees_band(60, 12)
    assert (low, high) == pytest.approx((10.79, 13.27), abs=0.01)
    assert low == pytest.approx(chi2.ppf(0.025, 720) / 60)


def test_covered_by_hand():
    assert covered(np.array([-0.9, 1.1]), np.array([1.0, 1.0]), 1).tolist() == [True, False]


def test_the_alarm_has_a_yellow_level_below_the_one_that_rings():
    said = [alarm_word(misfit) for misfit in (0.0, 0.75, 0.76, 1.0, 1.01, np.inf, np.nan)]
    assert said == ["silent", "silent", "yellow", "yellow", "rings", "rings", "rings"]
