"""The time update's products against plain NumPy, and what becomes of a motion that cannot be predicted."""

import newton_euler as twin
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded import recording
from running import Running, gain_columns, half_way, line_wrenches

from jawenv.filter.updates.time_update import all_finite, predict_by_tension, predict_cov, time_scratch_dtype
from jawenv.kernels.compiled import njit

N, COLUMNS = 10, 32


def memory(total):
    """The time update's, with [A, G] in it."""
    scratch = np.zeros(1, dtype=time_scratch_dtype(6, 6, N))[0]
    scratch["total"] = total
    return scratch


@njit
def predict(belief, noise_variance, scratch):
    predict_cov(belief.motion_cov, noise_variance, scratch)


@settings(max_examples=30, deadline=None, derandomize=True, database=None)
@given(seed=st.integers(0, 10_000), spread=st.floats(0.0, 4.0))
def test_the_covariance_is_that_of_the_linear_system(seed, spread):
    """A P A^T + G W G^T, symmetric to the bit, whatever the sizes of the states."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-spread, 0.0, N)
    total = rng.normal(size=(N, N + 6)) * size[:, None] / np.append(size, np.ones(6))
    root = rng.normal(size=(N, 2 * N)) * size[:, None]
    P, W = root @ root.T, rng.uniform(0.0, 1.0, 6)
    expected = total[:, :N] @ P @ total[:, :N].T + total[:, N:] @ np.diag(W) @ total[:, N:].T
    belief = np.zeros(1, dtype=[("motion_cov", "f8", (N, N))])[0]
    belief["motion_cov"] = P
    predict(belief, W, memory(total))
    covariance = belief["motion_cov"]
    sd = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(covariance / np.outer(sd, sd), expected / np.outer(sd, sd), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(covariance, covariance.T)


def test_the_derivative_by_the_tensions_goes_through_motion_and_wrench(rng):
    total, wrench = rng.normal(size=(N, N + 6)), rng.normal(size=(6, COLUMNS))
    by_tension = rng.normal(size=(N, COLUMNS))
    expected = total[:, :N] @ by_tension + total[:, N:] @ wrench
    scratch = memory(total)
    scratch["line_wrench"] = wrench
    predict_by_tension(by_tension, scratch)
    np.testing.assert_allclose(by_tension, expected, rtol=1e-12, atol=1e-12)


def test_one_value_that_is_no_number_is_noticed():
    values = np.ones(10)
    assert all_finite(values)
    for bad in (np.nan, np.inf, -np.inf):
        values[7] = bad
        assert not all_finite(values)


@pytest.mark.parametrize("early", [True, False], ids=["early", "late"])
def test_a_tick_takes_all_of_it_together(early):
    """Lines half way at the rates before the tick, or to what the past predicts, and the trend before it, balanced."""
    running = Running(recording().records[0], early=early).run(30)
    belief, record = running.belief, running.record
    before, V, P, trend = (belief[name].copy() for name in ("motion", "by_tension", "motion_cov", "trend"))
    running.predict(30)
    A, G = np.split(running.scratch["time"]["step"]["total"], [running.size], axis=1)
    middle = half_way(record.jaw, before, running.led(before))
    lines = line_wrenches(record.jaw, belief["basis"], *middle, *gain_columns(running, before, trend))
    expected = A @ V[:, : running.columns] + G @ lines
    np.testing.assert_allclose(running.by_tension, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    P = A @ P @ A.T + G @ np.diag(record.noise_variance[:6]) @ G.T
    sd = np.sqrt(np.diag(P))
    np.testing.assert_allclose(belief["motion_cov"] / np.outer(sd, sd), P / np.outer(sd, sd), rtol=0, atol=1e-10)
    assert np.abs(trend).max() > 0.1 and np.abs(belief["trend"] - trend).max() > 1e-3


def test_the_past_predicts_a_tick_by_the_smoothed_reading_alone():
    """Ten steps of Newton's and Euler's equations; what the load cell reads in the tick changes nothing."""
    running = Running(recording().records[0], early=False).run(30)
    belief, record = running.belief, running.record
    before, held = belief["motion"].copy(), belief["smoothed"].copy()
    record.samples[30] += 1.0
    try:
        running.predict(30)
    finally:
        record.samples[30] -= 1.0
    state = before
    for _ in range(10):
        state = twin.runge_kutta(
            lambda t, s: twin.state_rate(record.jaw, belief["point"], s, held), state, record.dt / 10
        )
    change = np.abs(belief["motion"] - before)
    assert (np.abs(belief["predicted"] - state) < 0.01 * change + 1e-9).all()
    assert (np.abs(belief["predicted"] - belief["motion"])[5:] > 0.01 * change[5:]).any()


def test_a_motion_that_is_no_number_stays_what_it_was_and_is_known_as_at_the_start():
    """The load cell reads a force that moves the jaw beyond all numbers; the next readings bring the motion back."""
    record = recording().records[0]
    running, sound = Running(record).run(40), Running(record).run(60)
    motion, smoothed = running.belief["motion"].copy(), running.belief["smoothed"].copy()
    samples = record.samples[40].copy()
    record.samples[40] = 1e300
    try:
        running.predict(40)
    finally:
        record.samples[40] = samples
    belief = running.belief
    np.testing.assert_array_equal(belief["motion"], motion)
    np.testing.assert_array_equal(belief["motion_cov"], np.diag(record.start_sd**2))
    np.testing.assert_array_equal(belief["by_tension"], 0.0)
    belief["trend"], belief["smoothed"] = 0.0, smoothed  # of the load cell's own, which is another matter
    running.update(41)
    running.run_on(41, 60)
    sd = np.sqrt(np.diag(sound.belief["motion_cov"]))
    assert (np.abs(belief["motion"] - sound.belief["motion"]) < 5.0 * sd).all()
    assert np.isfinite(running.information).all() and np.isfinite(running.score).all()
