"""A log tells the curve and the total pull, neither side nor muscle; what no relaxed jaw does is not believed."""

from functools import cache

import numpy as np
import pytest

from jawenv.anatomy import cohort
from jawenv.recordings.stretcher.fit import Assumed
from jawenv.recordings.stretcher.identified import pulls, stretched
from jawenv.recordings.stretcher.statics import Statics
from tests.stretched_logs import TRISMUS, log_of, patient

KNOWN = Assumed(reference_mm=0.0, tone_N=0.0, tilt_deg=0.0)


@cache
def found(assumed=None, name="trismus"):
    population = cohort(name)
    return stretched(log_of(patient(population=population)), population, assumed)


@pytest.mark.parametrize("assumed", [None, KNOWN])
def test_the_curve_is_the_jaws(assumed):
    result = found(assumed)
    assert result.believed and result.openings.tolist() == [5.0, 10.0, 15.0, 20.0]
    low, high = np.quantile(result.forces, (0.01, 0.99), axis=0)
    truth = Statics().forces(patient(), result.openings)
    assert ((low < truth) & (truth < high)).all()


def test_a_place_of_the_teeth_that_is_known_makes_the_curve_narrow():
    known, unknown = (np.log(found(assumed).forces).std(axis=0)[2] for assumed in (KNOWN, None))
    assert known < 0.03 and unknown > 0.05


def test_the_total_pull_is_told_and_the_side_is_not():
    before, after = pulls(found().prior), pulls(found().theta)
    assert after["all"].std() < 0.75 * before["all"].std()
    assert after["left : right"].std() > 0.8 * before["left : right"].std()


def test_a_side_that_cannot_be_told_is_both():
    ratio = pulls(found(name="one_sided").theta)["left : right"]
    assert 0.3 < (ratio > 0.0).mean() < 0.7


def test_teeth_that_meet_elsewhere_are_allowed_for():
    result = stretched(log_of(patient(), reference_mm=2.0), TRISMUS)
    low, high = np.quantile(result.forces[:, 2], (0.01, 0.99))
    assert result.believed and low < Statics().forces(patient(), np.array([15.0]))[0] < high


def test_a_return_below_the_opening_is_refused_and_said():
    result = stretched(log_of(patient(), creep=0.3), TRISMUS)
    assert not result.believed and len(result.theta) == 0
    assert "no relaxed jaw of this cohort" in result.doubts[0] and "the return takes" in result.doubts[1]


def test_a_jaw_of_another_cohort_is_refused():
    assert not stretched(log_of(patient(population=cohort("severe")), mm=14.0), cohort("healthy")).believed


def test_the_same_log_and_seed_give_the_same_draws():
    log = log_of(patient())
    one, other = (stretched(log, TRISMUS, draws=20) for _ in range(2))
    np.testing.assert_array_equal(one.theta, other.theta)
