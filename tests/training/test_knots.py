"""Maneuvers beside another one: offsets at knots."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from jawenv.device.channels import FASTEST_TARGET
from jawenv.playing.maneuvers import Maneuver
from training.search.knots import SIZE, STEP_S, Knots, length_s
from training.search.optimise import CANDIDATE

TIMES = STEP_S * np.arange(1, 11)


@pytest.mark.parametrize("name", ["designed", "opening_with_swings"])
def test_without_offsets_a_maneuver_is_itself(name):
    base = Maneuver.named(name)
    knots = Knots(base, 2.0)
    again = knots.maneuver(knots.start, CANDIDATE)
    np.testing.assert_allclose(again.targets(TIMES).value, base.targets(TIMES).value, atol=1e-5)


def test_what_lies_behind_the_horizon_stays():
    base = Maneuver.named("designed")
    assert length_s(base) == 30.0 and length_s(Maneuver.named("opening_with_swings")) == 0.0
    knots = Knots(base, 4.0)
    changed = knots.targets(knots.start + 0.3)
    late = STEP_S * np.arange(27, 151)  # a second later any difference is caught up
    np.testing.assert_allclose(changed[26:], base.targets(late).value, atol=1e-9)
    assert np.abs(changed[:20] - base.targets(STEP_S * np.arange(1, 21)).value).max() > 0.05


def test_another_maneuver_follows_after_the_horizon():
    """It is reached within two seconds, and changes nothing before."""
    base, then = Maneuver.named("refined"), Maneuver.named("opening_with_swings")
    knots, alone = Knots(base, 10.0, then), Knots(base, 10.0)
    path, own = knots.targets(knots.start), alone.targets(alone.start)
    np.testing.assert_array_equal(path[:50], own[:50])
    late = STEP_S * np.arange(66, 151)
    np.testing.assert_allclose(path[65:], then.targets(late).value, atol=1e-9)
    assert np.abs(path[65:] - own[65:]).max() > 0.1


def test_a_number_moves_its_channel_at_its_knot():
    knots = Knots(Maneuver.named("hold_still"), 2.0)
    numbers = np.zeros((5, 4))
    numbers[1, 2] = 0.5
    moved = knots.targets(numbers.ravel()) - knots.targets(knots.start)
    expected = np.zeros((10, 4))
    expected[2:5, 2] = 0.5 * SIZE[2] * np.array([0.5, 1.0, 0.5])
    np.testing.assert_allclose(moved, expected, atol=1e-12)


@given(arrays(float, 20, elements=st.floats(-50.0, 50.0)))
def test_any_numbers_make_a_maneuver_that_the_device_can_follow(numbers):
    knots = Knots(Maneuver.named("designed"), 2.0)
    path = np.vstack([np.zeros(4), knots.targets(numbers)])
    assert (np.abs(np.diff(path, axis=0)) <= np.array(FASTEST_TARGET) * STEP_S + 1e-12).all()
    np.testing.assert_allclose(knots.maneuver(numbers, CANDIDATE).targets(TIMES).value, path[1:11], atol=1e-5)
