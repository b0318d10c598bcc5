"""Equilibria on springs are those of the path of opening, and their derivatives are those of differences."""

import numpy as np
import pytest

from jawenv.recordings.stretcher.statics import BY_END, BY_TILT, BY_TONE, OPENING, RATE, Statics
from tests.passive_opening import pull_to_open
from tests.stretched_logs import patient

ENDS = np.array([0.003, 0.01, 0.018, 0.025])
THETA = patient()


@pytest.fixture(scope="module")
def statics():
    return Statics()


def hung(statics, theta=THETA, ends=ENDS, tone=0.0, tilt=0.0):
    openings, poses = statics.path(THETA, 30.0)
    start = np.stack([np.interp(1e3 * ENDS, openings, poses[:, i]) for i in range(5)], -1)
    return statics.hung(theta, ends, start, tone, tilt, steps=20)


def test_forces_are_those_of_a_slow_opening(statics):
    openings = (5.0, 10.0, 15.0, 20.0, 25.0)
    np.testing.assert_allclose(statics.forces(THETA, np.array(openings)), pull_to_open(THETA, openings), rtol=1e-3)


def test_the_jaw_is_at_rest(statics):
    assert (hung(statics)[:, RATE] < 1e-5).all()


@pytest.mark.parametrize("parameter", range(12))
def test_derivatives_by_the_muscles(statics, parameter):
    step = 1e-4 * (np.arange(12) == parameter)
    slope = (hung(statics, THETA + step) - hung(statics, THETA - step))[:, OPENING] / 2e-4
    np.testing.assert_allclose(hung(statics)[:, parameter], slope, rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize(
    ("column", "more", "less", "step", "tolerance"),
    [
        (BY_END, {"ends": ENDS + 1e-6}, {"ends": ENDS - 1e-6}, 2e-6, 1e-5),
        (BY_TONE, {"tone": 1e-3}, {"tone": -1e-3}, 2e-3, 1e-5),
        (BY_TILT, {"tilt": 1e-3}, {"tilt": -1e-3}, 2e-3, 0.01),
    ],
)
def test_derivatives_by_the_rest(statics, column, more, less, step, tolerance):
    slope = (hung(statics, **more) - hung(statics, **less))[:, OPENING] / step
    np.testing.assert_allclose(hung(statics)[:, column], slope, rtol=tolerance)


def test_beyond_its_branch_a_jaw_has_no_force(statics):
    assert np.isnan(statics.forces(THETA, np.array([10.0, 90.0]))).tolist() == [False, True]


def test_a_tilted_head_pulls_otherwise():
    openings = np.array([10.0])
    assert abs(Statics(-90.0).forces(THETA, openings) - Statics().forces(THETA, openings))[0] > 0.1
