"""Sine and cosine of the kernels, against numbers of many digits."""

import numpy as np
import pytest

from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import sin_cos


@njit
def both(x, sines, cosines):
    for i in range(x.shape[0]):
        sines[i], cosines[i] = sin_cos(x[i])


def sines_and_cosines(x):
    x = np.asarray(x, dtype=np.float64)
    sines, cosines = np.empty_like(x), np.empty_like(x)
    both(x, sines, cosines)
    return sines, cosines


def sample(largest, count=100_000):
    return np.random.default_rng(0).uniform(-largest, largest, count)


@pytest.mark.parametrize("largest", [1e-8, 0.1, 1.0, 7.0, 100.0, 1e4, 1e6])
def test_to_two_units_in_the_last_place(largest):
    x = sample(largest)
    for actual, exact in zip(sines_and_cosines(x), (np.sin(x.astype("g")), np.cos(x.astype("g"))), strict=True):
        # Near a zero of a large angle the digits of pi end: there the error is a unit in the last place of 1e-5.
        unit = np.spacing(np.maximum(np.abs(exact).astype(float), 1e-16 * largest / 1.1e-16 * 1e-5))
        assert np.max(np.abs(actual - exact) / unit) <= 2.0


def test_quarter_turns():
    sines, cosines = sines_and_cosines(0.5 * np.pi * np.arange(-4, 5))
    np.testing.assert_allclose(sines, [0, 1, 0, -1, 0, 1, 0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(cosines, [1, 0, -1, 0, 1, 0, -1, 0, 1], atol=1e-15)


def test_beyond_a_million_radians_it_is_a_number():
    for values in sines_and_cosines([1e9, -1e12, 1e15]):
        assert np.all(np.abs(values) <= 1.0 + 1e-15)


def test_what_is_no_number_has_none():
    for values in sines_and_cosines([np.nan]):
        assert np.isnan(values).all()
