import numpy as np
import pytest

from jawenv.metrics import identified, rmse, rmse_over_bound, time_to, worst_sd


def test_worst_sd_is_the_largest_over_parameters():
    assert worst_sd(np.array([[0.1, 0.3], [0.4, 0.2]])).tolist() == [0.3, 0.4]


def test_time_to_is_the_first_time_of_the_worst_parameter():
    time = np.array([0.0, 1.0, 2.0, 3.0])
    sd = np.array(
        [[[0.5, 0.5], [0.1, 0.3], [0.1, 0.1], [0.05, 0.12]], [[0.5, 0.5], [0.4, 0.01], [0.3, 0.01], [0.2, 0.01]]]
    )
    assert time_to(sd, time, 0.1).tolist() == [2.0, np.inf]
    assert time_to(sd, time, 0.5).tolist() == [0.0, 0.0]


def test_time_to_ignores_times_that_do_not_count():
    sd = np.array([[[0.1], [0.3], [0.1]], [[0.1], [0.1], [0.1]]])
    counts = np.array([[False, True, False], [False, True, True]])
    assert time_to(sd, np.arange(3.0), 0.1, counts).tolist() == [np.inf, 1.0]


def test_identified_needs_a_small_sd_and_the_truth_inside():
    mean, sd = np.zeros(4), np.array([0.05, 0.05, 0.05, 0.2])
    truth = np.array([0.097, 0.099, -0.2, 0.0])  # 1.94, 1.98 and 4 sigma away; the last has too large an sd
    assert identified(mean, sd, truth).tolist() == [True, False, False, False]


def test_rmse_by_hand():
    assert rmse(np.array([3.0, -4.0])) == pytest.approx(np.sqrt(12.5))


def test_rmse_over_bound_averages_squares_before_the_ratio():
    error, bound = np.array([[1.0], [7.0]]), np.array([[3.0], [4.0]])
    assert rmse_over_bound(error, bound) == pytest.approx([np.sqrt(25.0 / 12.5)])
