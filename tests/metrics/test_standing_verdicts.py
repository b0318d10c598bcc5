"""The verdicts of many beliefs at once are those of one after the other, and stand from the last change on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from jawenv.metrics.precision import for_good
from jawenv.metrics.standing import _both_below as both_below
from jawenv.metrics.standing import standing
from jawenv.metrics.verdicts import FINDINGS, verdicts

NUMBER = st.floats(-4.0, 4.0)


@settings(max_examples=60, deadline=None)
@given(NUMBER, NUMBER, st.floats(-0.99, 0.99))
def test_two_normals_together(h, k, correlation):
    expected = multivariate_normal.cdf([h, k], cov=[[1.0, correlation], [correlation, 1.0]])
    assert both_below(np.array(h), np.array(k), np.array(correlation)) == pytest.approx(expected, abs=1e-6)


def test_many_beliefs_at_once_are_judged_like_one():
    rng = np.random.default_rng(1)
    mean = np.log(np.tile([2.0, 12.0], 6)) + rng.normal(scale=0.5, size=(40, 12))
    root = rng.normal(size=(40, 12, 12))
    cov = 0.02 * rng.uniform(0.0, 1.0, (40, 1, 1)) * (root @ root.mT / 12.0 + np.eye(12))
    prior_sd = np.full(12, 0.2)
    one = [[each.word in FINDINGS for each in verdicts(*belief, prior_sd)] for belief in zip(mean, cov, strict=True)]
    found = standing(mean, cov, prior_sd)
    assert np.array_equal(found, one)
    assert found.any() and not found.all()


def test_for_good_is_after_the_last_change():
    holds = np.array([[1, 1, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0], [0, 0, 0]], dtype=bool)
    assert for_good(holds, np.array([0.0, 1.0, 2.0])).tolist() == [0.0, 1.0, 2.0, np.inf, np.inf]


def test_for_good_counts_from_a_belief_that_counts():
    holds = np.array([[False, True, True], [True, True, True], [True, True, True]])
    counts = np.array([[True, False, True], [False, True, False], [False, False, False]])
    assert for_good(holds, np.arange(3.0), counts).tolist() == [2.0, 1.0, np.inf]
