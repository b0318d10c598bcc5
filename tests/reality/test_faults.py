"""Readings that are lost and readings that freeze: how many, when, and what they show."""

import numpy as np
import pytest
from reality_states import Tissue, drawn_muscles

from jawenv.reality.sensors import fail

KEY = np.uint64(11), np.uint64(12)
TICKS = 2000


def failed(jaw, rng, ticks=TICKS, key=KEY, **options):
    """What 12 encoders (T, 12) and the load cell (T, 3, 6) would have read, and what they read."""
    tissue = Tissue(jaw, drawn_muscles(rng), **options)
    encoders, cell = rng.normal(size=(ticks, 12)), rng.normal(size=(ticks, 3, 6))
    measured, samples, faults = encoders.copy(), cell.copy(), np.empty(20)
    for k in range(ticks):
        fail(tissue.reality, tissue.state, key, k, measured[k], samples[k], faults)
    return encoders, cell, measured, samples


def test_the_shares_are_those_asked_for(jaw, rng):
    """36,000 channel-ticks: the shares' standard errors are 0.002."""
    encoders, cell, measured, samples = failed(jaw, rng, lost_share=0.2, frozen_share=0.1)
    lost = np.hstack([np.isnan(measured), np.isnan(samples).any(axis=1)])
    assert lost.mean() == pytest.approx(0.2, abs=0.008)
    changed = np.hstack([measured != encoders, (samples != cell).any(axis=1)])
    assert (changed & ~lost).mean() == pytest.approx(0.1, abs=0.007)
    assert np.abs(lost.mean(axis=0) - 0.2).max() < 0.045, "each channel, of which the standard error is 0.009"
    np.testing.assert_array_equal(np.isnan(samples).all(axis=1), np.isnan(samples).any(axis=1))


def test_a_frozen_sensor_shows_what_it_showed_last(jaw, rng):
    encoders, cell, measured, samples = failed(jaw, rng, frozen_share=0.4)
    for true, read in ((encoders[1:], measured[1:]), (cell[1:, 2], samples[1:, 2])):
        frozen = read[1:] != true[1:]
        assert 0.35 < frozen.mean() < 0.45
        np.testing.assert_array_equal(read[1:][frozen], read[:-1][frozen])
    stuck = samples[:, 0] != cell[:, 0]
    for i in (1, 2):
        np.testing.assert_array_equal(samples[:, i][stuck], samples[:, 0][stuck])


def test_a_sensor_that_is_frozen_from_the_start_shows_nothing(jaw, rng):
    """A number that it never read, 0 say, would be believed: it repeats none."""
    encoders, cell, measured, samples = failed(jaw, rng, ticks=1, frozen_share=0.4)
    missing = np.isnan(measured)
    assert 0 < missing.sum() < 12
    np.testing.assert_array_equal(measured[~missing], encoders[~missing])
    missing = np.isnan(samples)
    np.testing.assert_array_equal(samples[~missing], cell[~missing])


def test_a_lost_reading_is_not_what_a_frozen_one_repeats(jaw, rng):
    """The sensor had the number, which got lost on the way: it can freeze there."""
    _, _, measured, _ = failed(jaw, rng, lost_share=0.45, frozen_share=0.45)
    assert np.isnan(measured).mean() < 0.5


def test_the_faults_are_those_of_key_and_tick(jaw):
    same, again, other = (
        np.isnan(failed(jaw, np.random.default_rng(0), 50, key, lost_share=0.3)[2]) for key in (KEY, KEY, KEY[::-1])
    )
    np.testing.assert_array_equal(same, again)
    assert not np.array_equal(same, other)
