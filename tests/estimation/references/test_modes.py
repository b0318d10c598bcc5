"""A sum of normals: its moments, which modes are kept, and that one mode alone stays what it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jawenv.estimation.online import replay
from jawenv.estimation.online.state import belief_dtype
from jawenv.estimation.references import mixture

P = 4


def empty_belief():
    """Two muscles, nothing known."""
    return np.zeros(1, dtype=belief_dtype(2, 2, 4, 3))[0]


def random_normal(rng):
    """A mean and a positive definite covariance."""
    root = rng.standard_normal((P, P))
    return rng.standard_normal(P), root @ root.T + 0.1 * np.eye(P)


def keep(belief, mean, cov, density):
    belief["mode_mean"], belief["mode_cov"] = mean, cov
    return mixture.keep_mode(belief, density, np.zeros(P))


@settings(deadline=None, max_examples=50)
@given(
    seed=st.integers(0, 10_000),
    densities=st.lists(st.floats(-40.0, 40.0), min_size=1, max_size=mixture.MOST_MODES, unique=True),
)
def test_mean_and_covariance_are_those_of_the_sum(seed, densities):
    """By the raw second moment, which shares no formula with the running update."""
    rng, belief = np.random.default_rng(seed), empty_belief()
    normals = [random_normal(rng) for _ in densities]
    for k, ((mean, cov), density) in enumerate(zip(normals, densities, strict=True)):
        belief["modes_mean"][k], belief["modes_cov"][k], belief["modes_density"][k] = mean, cov, density
    belief["n_modes"] = len(densities)
    best = mixture.densest_mode(belief)
    assert best == np.argmax(densities)
    belief["mode_mean"], belief["mode_cov"] = normals[best]
    mixture.set_others(belief)
    mixture.sum_up(belief)
    weights = np.exp(mixture.TRUST * (np.array(densities) - max(densities)))
    weights /= weights.sum()
    assert belief["others_weight"] == pytest.approx(1.0 - weights[best], abs=1e-7)
    mean = sum(w * m for w, (m, _) in zip(weights, normals, strict=True))
    second = sum(w * (c + np.outer(m, m)) for w, (m, c) in zip(weights, normals, strict=True))
    np.testing.assert_allclose(belief["mean"], mean, rtol=0, atol=1e-6)
    np.testing.assert_allclose(belief["cov"], second - np.outer(mean, mean), rtol=0, atol=1e-5)
    assert np.linalg.eigvalsh(belief["cov"]).min() > 0.0


def test_without_others_the_belief_is_the_mode_to_the_bit(rng):
    belief = empty_belief()
    belief["mode_mean"], belief["mode_cov"] = random_normal(rng)
    keep(belief, belief["mode_mean"].copy(), belief["mode_cov"].copy(), 3.0)
    mixture.set_others(belief)
    mixture.sum_up(belief)
    assert belief["others_weight"] == 0.0
    np.testing.assert_array_equal(belief["mean"], belief["mode_mean"])
    np.testing.assert_array_equal(belief["cov"], belief["mode_cov"])


def test_of_modes_that_are_the_same_the_denser_is_kept(rng):
    belief = empty_belief()
    mean, cov = random_normal(rng)
    sd = np.sqrt(np.diag(cov))
    assert keep(belief, mean, cov, 1.0) == 0
    assert keep(belief, mean + 0.9 * mixture.SAME * sd, cov, 0.5) == -1
    assert keep(belief, mean + 0.9 * mixture.SAME * sd, cov, 1.5) == 0
    np.testing.assert_array_equal(belief["modes_mean"][0], mean + 0.9 * mixture.SAME * sd)
    assert keep(belief, mean + 3.0 * sd, cov, -5.0) == 1
    assert belief["n_modes"] == 2 and mixture.densest_mode(belief) == 0
    np.testing.assert_array_equal(belief["modes_density"][:2], [1.5, -5.0])
    mixture.forget_modes(belief)
    assert mixture.densest_mode(belief) == -1 and mixture.nearest_mode(belief) == (-1, np.inf)


def test_a_mode_of_no_weight_changes_nothing(rng):
    belief = empty_belief()
    mean, cov = random_normal(rng)
    keep(belief, mean + 9.0, cov, -100.0)
    keep(belief, mean, cov, 0.0)
    mixture.set_others(belief)
    mixture.sum_up(belief)
    np.testing.assert_array_equal(belief["mean"], mean)
    np.testing.assert_array_equal(belief["cov"], cov)


def test_there_is_room_for_a_mode_of_every_start():
    """Those of the filter and the smoother's path; a kernel would write past the end without a word."""
    assert replay.N_STARTS + 1 <= mixture.MOST_MODES
