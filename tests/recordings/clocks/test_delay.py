"""A delay of the forces: found, taken out, and not found where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from jawenv.recordings.clocks.delay import _shifted, delay_of, in_time
from jawenv.recordings.identification import identified
from tests.recordings.several.test_together import played


@pytest.mark.parametrize("late_s", [0.01, 0.03])
def test_a_delay_is_found_and_taken_out(late_s):
    record = played(0, "refined")
    moved, delay = in_time(_shifted(record, -late_s))
    assert delay.seconds == pytest.approx(late_s, abs=0.004) and "ms late" in str(delay)
    found, honest = (identified(one).estimate for one in (moved, record))
    np.testing.assert_allclose(found.mean[-1], honest.mean[-1], atol=0.5 * honest.sd[-1].max() + 0.05)


def test_no_delay_leaves_the_recording_as_it_is():
    record = played(0, "refined")
    same, delay = in_time(record)
    assert same is record and not delay.shown and abs(delay.seconds) < 0.004
    exact = replace(record, knowledge=type(record.knowledge)())
    assert in_time(_shifted(exact, -0.03))[1].nats == 0.0
    assert delay_of(record.until(0.5)).nats == 0.0


def test_fifty_milliseconds_are_named_and_left():
    late = _shifted(played(0, "refined"), -0.05)
    same, delay = in_time(late)
    assert same is late and delay.too_late and "more than the 30 ms" in str(delay)


def test_forces_are_moved_between_samples():
    record = played(0, "refined")
    np.testing.assert_array_equal(_shifted(record, 0.0).samples, record.samples)
    np.testing.assert_allclose(_shifted(record, 0.01).samples[:-1], record.samples[1:], atol=1e-9)
