"""A sum of normals: its moments, which modes are kept, and that one mode alone stays what it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jawenv.filter.belief.state import belief_dtype
from jawenv.references import mode_search
from jawenv.references.modes import (
    MAX_MODES,
    SAME,
    TRUST,
    keep_mode,
    mixture_moments,
    modes_dtype,
    nearest_mode,
)

P = 4


class Modes:
    """Modes of two muscles' parameters, none at first, and a belief to keep as one."""

    def __init__(self):
        self.modes = np.zeros(1, dtype=modes_dtype(P))[0]
        self.belief = np.zeros(1, dtype=belief_dtype(2, 10))[0]

    def keep(self, mean, cov, density):
        self.belief["mean"], self.belief["cov"] = mean, cov
        keep_mode(self.modes, self.belief, density)

    def nearest(self, mean, cov):
        self.belief["mean"], self.belief["cov"] = mean, cov
        return nearest_mode(self.modes, self.belief)


def random_normal(rng):
    """A mean and a positive definite covariance."""
    root = rng.standard_normal((P, P))
    return rng.standard_normal(P), root @ root.T + 0.1 * np.eye(P)


@settings(deadline=None, max_examples=50, derandomize=True, database=None)
@given(
    seed=st.integers(0, 10_000),
    densities=st.lists(st.floats(-40.0, 40.0), min_size=1, max_size=MAX_MODES, unique=True),
)
def test_mean_and_covariance_are_those_of_the_sum(seed, densities):
    """By the raw second moment, which shares no formula with the sum's own."""
    rng, modes = np.random.default_rng(seed), Modes().modes
    normals = [random_normal(rng) for _ in densities]
    for k, ((mean, cov), density) in enumerate(zip(normals, densities, strict=True)):
        modes["mean"][k], modes["cov"][k], modes["density"][k] = mean, cov, density
    modes["number"] = len(densities)
    weights = np.exp(TRUST * (np.array(densities) - max(densities)))
    weights /= weights.sum()
    expected = sum(w * m for w, (m, _) in zip(weights, normals, strict=True))
    second = sum(w * (c + np.outer(m, m)) for w, (m, c) in zip(weights, normals, strict=True))
    mean, cov = mixture_moments(modes)
    np.testing.assert_allclose(mean, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(cov, second - np.outer(expected, expected), rtol=0, atol=1e-9)
    assert np.linalg.eigvalsh(cov).min() > 0.0


def test_one_mode_alone_is_the_sum_to_the_bit(rng):
    search, (mean, cov) = Modes(), random_normal(rng)
    search.keep(mean, cov, 3.0)
    summed = mixture_moments(search.modes)
    np.testing.assert_array_equal(summed[0], mean)
    np.testing.assert_array_equal(summed[1], cov)


def test_of_modes_that_are_the_same_the_denser_is_kept(rng):
    search, (mean, cov) = Modes(), random_normal(rng)
    sd = np.sqrt(np.diag(cov))
    assert search.nearest(mean, cov) == (-1, np.inf)
    search.keep(mean, cov, 1.0)
    near = mean + 0.9 * SAME * sd
    search.keep(near, cov, 0.5)
    np.testing.assert_array_equal(search.modes["mean"][0], mean)
    search.keep(near, cov, 1.5)
    np.testing.assert_array_equal(search.modes["mean"][0], near)
    search.keep(mean + 3.0 * sd, cov, -5.0)
    assert search.modes["number"] == 2
    np.testing.assert_array_equal(search.modes["density"][:2], [1.5, -5.0])
    nearest, apart = search.nearest(mean + 2.5 * sd, cov)
    assert nearest == 1 and apart == pytest.approx(0.5)


def test_a_mode_of_no_weight_changes_nothing(rng):
    search, (mean, cov) = Modes(), random_normal(rng)
    search.keep(mean + 9.0, cov, -200.0)
    search.keep(mean, cov, 0.0)
    summed = mixture_moments(search.modes)
    np.testing.assert_allclose(summed[0], mean, rtol=0, atol=1e-12)
    np.testing.assert_allclose(summed[1], cov, rtol=0, atol=1e-12)


def test_there_is_room_for_a_mode_of_every_start():
    """Those of a search are the modes kept, the prior's mean and two bent ones; a kernel would write past the end."""
    modes = Modes().modes
    modes["number"], modes["density"] = MAX_MODES, np.arange(MAX_MODES)
    starts = mode_search._search_starts(modes, np.zeros(P), np.ones(P))
    assert len(starts) == mode_search.RESTARTS + 3 <= MAX_MODES
