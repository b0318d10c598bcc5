"""The load cell's samples lie on the parabola that fits a tick's force best."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from jawenv.envs.world.plants import add_moments, clear_moments, take_samples

MOMENTS = np.array([0.0, 0.5, 1.0])


def samples_of(force, parts):
    """Samples of a force over a tick of unit length, taken in by Simpson's rule in each of ``parts``."""
    samples = np.full((3, 6), np.nan)
    clear_moments(samples)
    for part in range(parts):
        for moment, weight in zip(MOMENTS, (1 / 6, 4 / 6, 1 / 6), strict=True):
            at = (part + moment) / parts
            add_moments(samples, np.full(6, force(at)), weight / parts, 2.0 * at - 1.0)
    take_samples(samples)
    return samples[:, 0]


@settings(deadline=None)  # the first call compiles
@given(mean=st.floats(-20, 20), slope=st.floats(-20, 20), parts=st.integers(2, 8))
def test_a_straight_force_is_read_as_it_is(mean, slope, parts):
    found = samples_of(lambda at: mean + slope * at, parts)
    assert np.allclose(found, mean + slope * MOMENTS, atol=1e-12 * (1 + abs(mean) + abs(slope)))


@settings(deadline=None)
@given(decay=st.floats(0.1, 8.0))
def test_any_other_is_fitted_by_least_squares(decay):
    times = (np.arange(20_000) + 0.5) / 20_000
    fit = np.polyfit(times, np.exp(-decay * times), 2)
    assert np.allclose(samples_of(lambda at: np.exp(-decay * at), 64), np.polyval(fit, MOMENTS), atol=1e-5)
