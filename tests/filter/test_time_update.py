"""What the past predicts of a tick, and what becomes of a motion that cannot be predicted."""

import newton_euler as twin
import numpy as np
from recorded import recording
from running import Running

from jawenv.filter.updates.time_update import all_finite


def test_one_value_that_is_no_number_is_noticed():
    values = np.ones(10)
    assert all_finite(values)
    for bad in (np.nan, np.inf, -np.inf):
        values[7] = bad
        assert not all_finite(values)


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
