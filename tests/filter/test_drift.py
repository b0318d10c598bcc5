"""Drift: beliefs that move further than what they claimed to know allows."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import recording
from running import Running
from scipy.stats import chi2

import jawenv
from agents import load_agent
from jawenv.filter.alarm.drift import EVERY, KEPT, judge_drift, threshold
from jawenv.recordings.identification import identified

P = 12


@pytest.fixture
def belief():
    return Running(recording().records[0]).belief


def judged_after(belief, readings, mean, cov):
    belief["mean"], belief["cov"], belief["readings"] = mean, cov, readings
    judge_drift(belief, np.empty(P))
    return float(belief["misfit"])


def test_it_is_the_distance_in_sds_of_the_first_belief(belief, rng):
    root = rng.normal(size=(P, P))
    cov, step = root @ root.T, rng.normal(size=P)
    assert judged_after(belief, EVERY, np.zeros(P), cov) == 0.0
    expected = step @ np.linalg.solve(cov, step) / threshold(P)
    assert judged_after(belief, 2 * EVERY, step, 0.1 * cov) == pytest.approx(expected, rel=1e-9)
    assert judged_after(belief, 3 * EVERY, np.zeros(P), 0.1 * cov) >= expected, "the largest stays"


def test_beliefs_are_kept_after_twice_as_many_readings_each(belief):
    kept = []
    for readings in range(1, 200 * EVERY, EVERY // 4):
        judged_after(belief, readings, np.zeros(P), np.eye(P))
        if belief["drift"]["kept"] > len(kept):
            kept.append(readings // EVERY)
    assert kept == [2**k for k in range(KEPT)]


def test_what_a_bayesian_learns_is_no_drift(belief, rng):
    """Means of independent normal numbers: the truth is drawn from the prior, and each reading halves what is left."""
    found = []
    for _ in range(200):
        belief["drift"]["kept"] = belief["drift"]["judged"] = 0
        belief["misfit"] = 0.0
        truth, mean, precision = rng.normal(size=P), np.zeros(P), 1.0
        for k in range(1, 12):
            mean = (precision * mean + truth + rng.normal(size=P)) / (precision + 1.0)
            precision += 1.0
            largest = judged_after(belief, k * EVERY, mean, np.eye(P) / precision)
        found.append(largest * threshold(P))
    assert np.quantile(found, 0.5) < chi2(P).ppf(0.99)
    assert np.max(found) < threshold(P)


def test_a_first_second_linearised_far_from_the_truth_is_given_up_with_its_claims():
    """A healthy side, whose first second under a prior of stiff muscles claims too much; filtered again it does not."""
    agent, world = load_agent("opening_with_swings_and_fore_aft"), {"record": True, "episode_s": 10.0}
    played = jawenv.play(agent, patients=1, seed=0, env_kwargs={"cohort": "one_sided", **world}).records[0]
    for prior in (played.prior, jawenv.cohort("patchy").prior, jawenv.cohort("anyone").prior):
        found = identified(replace(played, prior=prior))
        error = found.estimate.mean[-1] - played.truth
        assert error @ np.linalg.solve(found.estimate.cov[-1], error) < chi2(P).ppf(0.999)
        assert found.misfit < 1.0


def test_a_matrix_that_is_no_covariance_is_not_kept(belief):
    assert judged_after(belief, EVERY, np.zeros(P), -np.eye(P)) == 0.0
    assert belief["drift"]["kept"] == 0
