"""Guarding, slow creep and swallows: where each begins, what it comes to, and when."""

import numpy as np
import pytest
from reality_states import REST, TICK, Tissue, drawn_muscles, tensions

from jawenv.reality.tissue import straightened

WIDE = (7e-3, 0.0, 0.3, 0.0, 0.0)


def strains(tissue, q):
    """Independent: (6,) strain above rest, of the lengths that tensions of F_o = 1, b = 1 have."""
    ones = np.ones((6, 2))
    stretched, rest = (np.log(tensions(tissue.jaw, ones, pose)) for pose in (q, REST))
    return np.maximum(0.0, stretched - rest)


def test_guarding_goes_to_its_share_of_the_strain_beyond_the_onset(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, guarding_gain=2.0, guarding_onset=0.05)
    for _ in range(200):  # five lags of 40 ms are over after 20 ticks
        tension = tissue.tick(WIDE)
    passive = tensions(jaw, muscles, WIDE)
    beyond = np.maximum(0.0, strains(tissue, WIDE) - 0.05)
    assert beyond.max() > 0.05
    np.testing.assert_allclose(tension - passive, 2.0 * muscles[:, 0] * muscles[:, 1] * beyond, rtol=1e-9, atol=1e-12)


def test_no_guarding_within_the_onset(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, guarding_gain=2.0, guarding_onset=1.0)
    for _ in range(50):
        tension = tissue.tick(WIDE)
    np.testing.assert_allclose(tension, tensions(jaw, muscles, WIDE), rtol=1e-12)


def test_both_elements_creep_with_their_own_times(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, creep_share=0.3, creep_time_s=0.5, creep_slow_share=0.2, creep_slow_time_s=5.0)
    ticks = 400
    for _ in range(ticks + 1):
        tension = tissue.tick(WIDE)
    time, strain = ticks * TICK, strains(tissue, WIDE)
    lengthened = strain * (0.3 * -np.expm1(-time / 0.5) + 0.2 * -np.expm1(-time / 5.0))
    expected = tensions(jaw, muscles, WIDE) * np.exp(-muscles[:, 1] * lengthened)
    np.testing.assert_allclose(tension, expected, rtol=1e-9)


@pytest.mark.parametrize("share", [0.4, 1.0])
def test_a_straight_law_is_a_line_through_F_o_and_its_tension_at_a_fifth(jaw, rng, share):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, straight_share=share)
    F_o, b = muscles.T
    strain = np.log(tensions(jaw, np.ones((6, 2)), WIDE))
    line = F_o + (F_o * np.exp(0.2 * b) - F_o) * strain / 0.2
    expected = share * line + (1.0 - share) * tensions(jaw, muscles, WIDE)
    np.testing.assert_allclose(tissue.tick(WIDE), expected, rtol=1e-9)


def test_a_straight_law_creeps_too_and_its_tension_ends_at_nothing(jaw, rng):
    muscles = drawn_muscles(rng)
    crept = Tissue(jaw, muscles, straight_share=1.0, creep_share=0.3, creep_time_s=0.1)
    fresh = Tissue(jaw, muscles, straight_share=1.0)
    for _ in range(200):
        tension = crept.tick(WIDE)
    F_o, b = muscles.T
    lost = 0.3 * strains(crept, WIDE) * F_o * np.expm1(0.2 * b) / 0.2
    np.testing.assert_allclose(fresh.tick(WIDE) - tension, lost, rtol=1e-6)
    assert straightened(1.0, 2.0, 10.0, -0.2) == (0.0, 0.0)


def test_a_swallow_comes_when_it_is_due_and_goes(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, swallow_N=1.5, swallow_every_s=4.0)
    passive = tensions(jaw, muscles, REST)
    added = np.array([tissue.tick(REST) - passive for _ in range(1000)])
    assert np.ptp(added, axis=1) == pytest.approx(0.0, abs=1e-9)  # the same in all muscles
    course = added[:, 0]
    time = TICK * np.arange(1000) - 2.0  # the first one after half the time
    expected = 1.5 * np.where(np.mod(time, 4.0) < 1.0, np.sin(np.pi * np.mod(time, 4.0)), 0.0) * (time > -1e-9)
    np.testing.assert_allclose(course, expected, atol=0.05)
    assert course.max() == pytest.approx(1.5, abs=0.01) and course.min() > -1e-9
