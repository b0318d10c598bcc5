"""Treatments in a row: what is known grows, stays calibrated, and follows a patient who changes."""

from functools import cache

import numpy as np
import pytest
from rich.console import Console

from eval.kept.entries import Settings, load_entries
from eval.patient.courses import persons, play_courses
from eval.patient.treatments import Course, first_treatment, next_treatment
from jawenv.metrics import nees_band
from jawenv.playing.rollout import play
from jawenv.recordings.untold.learnt import identified_with_errors

PATIENTS, TREATMENTS, FIRST_SEED = 16, 5, 5100
OFFSET = {"cell_bias_N": 0.3, "cell_bias_N_m": 0.006}


def entry_of(cohort="trismus", episode_s=8.0, maneuver="opening_with_swings_and_fore_aft"):
    settings = Settings.of(1, FIRST_SEED, cohort=cohort, control="force", episode_s=episode_s)
    return load_entries([maneuver], settings.world)[0]


def course_of(entry, seed, drift=0.0, number=TREATMENTS):
    course = [first_treatment(entry, seed)]
    while len(course) < number:
        course.append(next_treatment(entry, course[-1], len(course) + 1, drift, seed))
    return course


@cache
def courses_of(cohort, drift):
    entry = entry_of(cohort)
    return [course_of(entry, FIRST_SEED + i, drift) for i in range(PATIENTS)]


@pytest.mark.parametrize(("cohort", "drift"), [("trismus", 0.0), ("one_sided", 0.03)])
def test_beliefs_narrow_and_stay_calibrated(cohort, drift):
    courses = courses_of(cohort, drift)
    sd = np.array([[np.sqrt(np.diagonal(each.cov[-1])) for each in course] for course in courses]).mean(axis=(0, 2))
    assert (np.diff(sd) < 0.0).all() and sd[-1] < 0.75 * sd[0]
    nees = np.array([[each.nees for each in course] for course in courses]).mean(axis=0)
    low, high = nees_band(PATIENTS, 12)
    assert low < nees[-1] < high, nees
    assert (nees > 0.8 * low).all() and (nees < 1.2 * high).all(), nees
    moved = np.std([course[-1].truth - course[0].truth for course in courses])
    assert moved == pytest.approx(drift * np.sqrt(TREATMENTS - 1), rel=0.2, abs=1e-12)


def test_a_drift_that_the_belief_did_not_widen_for_would_be_seen():
    """The band of the test above can be left: beliefs of a still patient do not fit one who changes."""
    entry, wrong = entry_of(), []
    for i, still in enumerate(courses_of("trismus", 0.0)[:3]):
        changed = course_of(entry, FIRST_SEED + i, 0.1)[-1].truth
        error = still[-1].mean[-1] - changed
        wrong.append(error @ np.linalg.solve(still[-1].cov[-1], error))
    assert np.mean(wrong) > 3.0 * nees_band(PATIENTS, 12)[1]


def test_the_first_treatment_is_what_play_plays():
    entry = entry_of()
    recording = play(entry.agent, patients=2, seed=FIRST_SEED, env_kwargs=entry.env_kwargs)
    for i in range(2):
        treatment = first_treatment(entry, FIRST_SEED + i)
        np.testing.assert_array_equal(treatment.truth, recording.truth[i])
        np.testing.assert_allclose(treatment.mean, recording.belief_mean[i], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(treatment.cov, recording.belief_cov[i], rtol=1e-6, atol=1e-12)


def test_the_only_treatment_ends_with_what_a_recording_of_it_teaches():
    """An offset that nobody told: the belief is that of ``identify``, in a course of one treatment alone."""
    settings = Settings.of(1, FIRST_SEED, cohort="trismus", control="targets", episode_s=12.0, reality=OFFSET)
    (entry,) = load_entries(["refined"], settings.world)
    plain, found = (first_treatment(entry, FIRST_SEED, untold=untold) for untold in (False, True))
    record = entry.play(1, FIRST_SEED, record=True, track_bound=False).records[0]
    told, last = identified_with_errors(record)
    np.testing.assert_allclose(found.mean[-1], told.estimate.mean[-1], atol=0.02)
    np.testing.assert_allclose(found.cov[-1], told.estimate.cov[-1], rtol=0.1, atol=1e-5)
    np.testing.assert_array_equal(found.cov[:-1], plain.cov[:-1])
    assert plain.shown is None and found.nees < 0.2 * plain.nees and last is not None
    part = play_courses(entry, Course(2), persons(FIRST_SEED, 1), Console(quiet=True))
    assert [each.shown for each in part[0]] == [None, None]


def test_the_noise_of_every_treatment_is_its_own_and_repeatable():
    entry = entry_of(episode_s=6.0)
    course, again = (course_of(entry, FIRST_SEED, number=3) for _ in range(2))
    for one, other in zip(course, again, strict=True):
        np.testing.assert_array_equal(one.mean, other.mean)
    gains = [np.linalg.inv(each.cov[-1]) - np.linalg.inv(each.cov[0]) for each in course[1:]]
    assert np.abs(gains[0] - gains[1]).max() > 0.0
    thin = course[0].thinned(5)
    assert len(thin.time) == 5 and thin.time[0] == 0.0 and thin.time[-1] == course[0].time[-1]
    assert thin.nees == course[0].nees
