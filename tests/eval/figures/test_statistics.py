import numpy as np
import pytest

from eval.figures import statistics

VALUES = np.random.default_rng(0).exponential(size=60)


def test_a_mean_has_an_interval_that_is_the_same_every_time():
    found = statistics.mean(VALUES)
    assert found.value == pytest.approx(VALUES.mean())
    assert found.low < found.value < found.high
    assert found == statistics.mean(VALUES)


def test_intervals_of_a_mean_cover_it_as_often_as_they_say():
    rng = np.random.default_rng(1)
    covered = [(i := statistics.mean(rng.exponential(size=40))).low <= 1.0 <= i.high for _ in range(200)]
    assert 0.88 <= np.mean(covered) <= 0.99


def test_intervals_of_several_means_hold_all_at_once_as_often_as_they_say():
    rng, hold_all, first_alone = np.random.default_rng(2), [], []
    mixed = np.eye(12) + 0.3
    for _ in range(200):
        found = statistics.means_together(rng.normal(size=(80, 12)) @ mixed)
        holds = [each.low <= 0.0 <= each.high for each in found]
        hold_all.append(all(holds))
        first_alone.append(holds[0])
    assert 0.90 <= np.mean(hold_all) <= 0.99
    assert np.mean(first_alone) > np.mean(hold_all)


def test_several_means_of_few_or_equal_patients():
    (alone,) = statistics.means_together(np.array([[2.0]]))
    assert alone.value == 2.0 and not alone.exists
    equal, other = statistics.means_together(np.array([[1.0, 0.0], [1.0, 4.0]]))
    assert (equal.low, equal.high) == (1.0, 1.0) and other.low < 2.0 < other.high
    assert np.isnan(statistics.means_together(np.empty((0, 3)))[2].value)


def test_a_median_over_patients_who_never_arrive():
    times = np.array([1.0, 2.0, 3.0, 4.0, np.inf, np.inf, np.inf, np.inf, np.inf])
    found = statistics.quantile(times, 0.5)
    assert found.value == np.inf
    assert found.low < np.inf
    assert statistics.quantile(np.full(4, np.inf), 0.5).high == np.inf


def test_one_patient_has_no_interval():
    found = statistics.mean(np.array([3.0]))
    assert found.value == 3.0
    assert not found.exists


def test_patients_who_all_agree_have_an_interval_without_width():
    assert statistics.mean(np.zeros(5)) == statistics.Interval(0.0, 0.0, 0.0)


def test_rmse_over_bound_of_errors_drawn_from_the_bound():
    rng = np.random.default_rng(3)
    bound = rng.uniform(0.1, 1.0, (300, 12))
    found = statistics.rmse_over_bound(2.0 * bound * rng.standard_normal(bound.shape), bound)
    assert found.low < 2.0 < found.high


def test_improvement_counts_ties_half_and_takes_never_for_late():
    one, other = np.array([1.0, 2.0, np.inf, 4.0]), np.array([2.0, 2.0, np.inf, np.inf])
    np.testing.assert_array_equal(statistics.better(one, other, higher=False), [1.0, 0.5, 0.5, 1.0])
    np.testing.assert_array_equal(statistics.better(one, other, higher=True), [0.0, 0.5, 0.5, 0.0])


def test_a_share_has_an_interval_also_at_its_ends():
    assert statistics.share_of(0, 10).low == 0.0 and 0.2 < statistics.share_of(0, 10).high < 0.35
    assert statistics.share_of(5, 10).value == 0.5
