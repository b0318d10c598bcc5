"""Counter-based noise: numpy's own Philox, and normals that are normal."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from jawenv.kernels.noise import fill_normals, philox

words = st.integers(0, 2**64 - 1)
KEY = (np.uint64(12345), np.uint64(2**63 + 7))


@settings(max_examples=100, derandomize=True)
@given(st.tuples(words, words), st.tuples(words, words, words, words))
def test_philox_is_numpys(key, counter):
    # numpy adds 1 to its 256-bit counter, least word first, before it draws.
    before = (sum(word << 64 * i for i, word in enumerate(counter)) - 1) % 2**256
    generator = np.random.Philox(key=np.array(key, dtype=np.uint64), counter=before)
    drawn = philox(tuple(map(np.uint64, key)), tuple(map(np.uint64, counter)))
    assert list(drawn) == list(generator.random_raw(4))


def normals(key, ticks, size=36):
    drawn = np.empty((len(ticks), size))
    for row, tick in zip(drawn, ticks, strict=True):
        fill_normals(key, tick, row)
    return drawn


def test_normals_are_standard_normal():
    drawn = normals(KEY, range(4000))
    assert stats.kstest(drawn.ravel(), "norm").pvalue > 0.01
    # Sixth moment included: tails matter to a filter. Bounds are four standard errors of n = 144,000.
    n = drawn.size
    for power, moment, variance in ((1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96), (6, 15, 10170)):
        assert abs(np.mean(drawn**power) - moment) < 4 * np.sqrt(variance / n)


def test_normals_are_independent_within_and_between_ticks_and_keys():
    first, other_key = normals(KEY, range(4000)), normals((KEY[0], KEY[1] + np.uint64(1)), range(4000))
    together = np.hstack([first[:-1], first[1:], other_key[:-1]])
    # Radius and angle of a Box-Muller pair would show up in the squares.
    for values in (together, together**2):
        correlation = np.corrcoef(values.T)
        off_diagonal = correlation[~np.eye(len(correlation), dtype=bool)]
        assert np.abs(off_diagonal).max() < 5.0 / np.sqrt(len(together))


def test_normals_depend_on_key_and_tick_alone():
    once = normals(KEY, [7, 0, 7, -1])
    np.testing.assert_array_equal(once[0], once[2])
    assert len(np.unique(once[[0, 1, 3]])) == 3 * 36
    np.testing.assert_array_equal(normals(KEY, [7], size=24)[0], once[0, :24])
