"""The score of a patient, on recordings of known outcome."""

from dataclasses import replace

import numpy as np
import pytest

from eval.benchmark.tasks import TASKS
from eval.kept.entries import load_entry
from eval.rows.times import Times, _within_for_good, restricted
from tests.metrics.linear_gaussian import linear_gaussian


@pytest.fixture
def recording():
    """Three patients, whose estimates are exact but where a test says otherwise."""
    given = linear_gaussian(3, noise=1.0)
    exact = np.repeat(given.truth[:, None], len(given.time), axis=1)
    nobody = np.zeros_like(given.violation)
    return replace(given, belief_mean=exact, violation=nobody, valid=~nobody, terminated=np.zeros(3, dtype=bool))


def off(recording, patient, steps, factor):
    """One parameter of a patient is estimated as so many times its truth at some steps."""
    recording.belief_mean[patient, steps, 1] += np.log(factor)
    return recording


def test_the_last_time_outside_counts_and_not_the_first_within(recording):
    time = recording.time
    off(recording, 0, slice(0, 3), 2.0)
    off(recording, 0, 5, 1.2)
    off(recording, 1, -1, 0.5)
    found = _within_for_good(recording, 0.10)
    assert found.tolist() == [time[6], np.inf, 0.0]
    assert restricted(found, 30.0).tolist() == [time[6], 30.0, 0.0]


def test_the_error_is_relative_to_the_truth_and_not_to_its_logarithm(recording):
    off(recording, 0, slice(0, 4), 1.0999)
    off(recording, 1, slice(0, 4), 1.1001)
    off(recording, 2, slice(0, 4), 0.901)
    assert _within_for_good(recording, 0.10).tolist() == [0.0, recording.time[4], 0.0]
    assert _within_for_good(recording, 0.05).tolist() == [recording.time[4]] * 3


def test_what_the_filter_claims_does_not_count(recording):
    vague = replace(recording, belief_cov=1e4 * recording.belief_cov)
    assert _within_for_good(vague, 0.05).tolist() == [0.0, 0.0, 0.0]


def test_a_crossed_limit_and_an_early_end_count_as_never(recording):
    recording.violation[0, 3] = True
    recording.terminated[1] = True
    assert _within_for_good(recording, 0.05).tolist() == [np.inf, np.inf, 0.0]


def test_what_is_not_asked_for_does_not_count(recording):
    off(recording, 0, slice(None), 2.0)
    asked = np.ones_like(recording.asked)
    asked[:2, 1] = False
    off(recording, 2, -1, 2.0)
    assert _within_for_good(replace(recording, asked=asked), 0.05).tolist() == [0.0, 0.0, np.inf]


def test_above_the_limit_of_comfort_nothing_is_found():
    """Whatever is estimated, at rest; a limit below 0 is nobody's."""
    entry = load_entry("hold_still", TASKS["jaw-asked"].settings().world)

    def nothing(done: int, steps: int) -> None: ...

    free, limited = (Times(100.0, 10.0, limit).play(entry, 2, 57_000, nothing) for limit in (0.03, -1.0))
    assert (free["score_s"] == 0.0).all()
    assert (limited["score_s"] == 10.0).all() and np.isinf(limited["within_0.2_s"]).all()
    assert (free["worst_sd"] == limited["worst_sd"]).all()
