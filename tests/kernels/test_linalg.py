"""Products, triangular solves and Cholesky factors against NumPy, for sizes that fill no register too."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba.core.errors import TypingError

from jawenv.kernels.cholesky import invert_positive, log_det, set_root, solve_decomposed, solve_in_place, solve_lower
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import (
    WIDE,
    add_product,
    add_scaled,
    add_squares,
    decompose,
    mirror,
    multiply,
    subtract_product,
    whiten,
)
from jawenv.kernels.records import record_dtype, record_zeros

SHAPES = [(1, 1, 1), (3, 5, 7), (5, 3, 11), (9, 13, 17), (12, 10, 35), (7, 2, 67)]  # (n, k, m)
seeds = st.integers(0, 2**32 - 1)
shapes = pytest.mark.parametrize("shape", SHAPES)


@njit
def all_products(matrices):
    multiply(matrices.a, matrices.b, matrices.product)
    add_product(matrices.a, matrices.b, matrices.more)
    subtract_product(matrices.a, matrices.b, matrices.less)
    add_squares(matrices.wide, matrices.squares)
    add_scaled(matrices.scaled, matrices.more, 0.3, matrices.less)


@njit
def whiten_rows(matrices):
    return decompose(matrices.factor) and solved(matrices)


@njit
def solved(matrices):
    whiten(matrices.factor, matrices.rows)
    return True


@cache
def product_matrices(n, k, m):
    """A wider left matrix than is needed: its first k columns count. Squares are of whole registers."""
    shapes = {
        "a": (n, k + 2),
        "b": (k, m),
        "product": (n, m),
        "more": (n, m),
        "less": (n, m),
        "scaled": (n, m),
        "wide": (k, WIDE * n),
        "squares": (WIDE * n, WIDE * n),
    }
    return record_zeros(1, record_dtype([(name, "f8", shape) for name, shape in shapes.items()]))[0]


def fill(record, rng):
    given = {}
    for name in record.dtype.names:
        record[name] = rng.normal(size=record[name].shape)
        given[name] = record[name].copy()
    return given


def definite(rng, size):
    root = rng.normal(size=(size, size + 2))
    return root @ root.T + 0.1 * np.eye(size)


def close(actual, desired):
    np.testing.assert_allclose(actual, desired, rtol=1e-12, atol=1e-12 * np.abs(desired).max())


@shapes
@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=seeds)
def test_products_are_numpys(shape, seed):
    matrices = product_matrices(*shape)
    before = fill(matrices, np.random.default_rng(seed))
    all_products(matrices)
    product = before["a"][:, : shape[1]] @ before["b"]
    close(matrices["product"], product)
    close(matrices["more"], before["more"] + product)
    close(matrices["less"], before["less"] - product)
    squares = before["squares"] + before["wide"].T @ before["wide"]
    close(np.triu(matrices["squares"]), np.triu(squares))
    mirror(matrices["squares"])
    close(matrices["squares"], np.triu(squares) + np.triu(squares, 1).T)
    close(matrices["scaled"], matrices["more"] + 0.3 * matrices["less"])
    np.testing.assert_array_equal(matrices["a"], before["a"])


@pytest.mark.parametrize("size", [1, 2, 5, 12, 19])
@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=seeds)
def test_factors_and_whitened_rows_are_numpys(size, seed):
    rng = np.random.default_rng(seed)
    fields = [("factor", "f8", (size, size)), ("rows", "f8", (size, 2 * size + 1))]
    matrices = record_zeros(1, record_dtype(fields))[0]
    matrix, rows = definite(rng, size), rng.normal(size=(size, 2 * size + 1))
    matrices["factor"], matrices["rows"] = matrix, rows
    assert whiten_rows(matrices)
    lower, diagonal = np.linalg.cholesky(matrix), np.arange(size)
    np.testing.assert_allclose(np.tril(matrices["factor"], -1), np.tril(lower, -1), atol=1e-10)
    np.testing.assert_allclose(matrices["factor"][diagonal, diagonal], 1.0 / np.diag(lower), rtol=1e-9)
    np.testing.assert_allclose(matrices["rows"], np.linalg.solve(lower, rows), rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("size", [1, 2, 5, 12, 19])
@settings(max_examples=20, derandomize=True, deadline=None)
@given(seed=seeds)
def test_what_follows_from_a_factor_is_numpys(size, seed):
    rng = np.random.default_rng(seed)
    matrix, right = definite(rng, size), rng.normal(size=size)
    factor, once, twice, inverse = matrix.copy(), right.copy(), right.copy(), np.empty((size, size))
    assert decompose(factor)
    assert log_det(factor) == pytest.approx(np.linalg.slogdet(matrix)[1], rel=1e-9, abs=1e-9)
    solve_lower(factor, once)
    np.testing.assert_allclose(once, np.linalg.solve(np.linalg.cholesky(matrix), right), rtol=1e-8, atol=1e-8)
    solve_decomposed(factor, twice)
    np.testing.assert_allclose(twice, np.linalg.solve(matrix, right), rtol=1e-7, atol=1e-7)
    assert invert_positive(matrix.copy(), inverse)
    np.testing.assert_allclose(inverse, np.linalg.inv(matrix), rtol=1e-7, atol=1e-7)
    np.testing.assert_array_equal(inverse, inverse.T)


@pytest.mark.parametrize("pivot", [0.0, -1.0, np.nan])
def test_what_is_not_positive_definite_has_no_factor(pivot):
    assert not decompose(np.diag([1.0, pivot, 1.0]))
    assert not invert_positive(np.diag([1.0, pivot, 1.0]), np.empty((3, 3)))


def test_the_root_of_a_semidefinite_matrix():
    rows = np.random.default_rng(0).normal(size=(7, 3))
    root = np.full((7, 7), np.nan)
    set_root(rows @ rows.T, root)
    np.testing.assert_allclose(root @ root.T, rows @ rows.T, atol=1e-6)
    np.testing.assert_array_equal(root, np.tril(root))


def test_any_square_system_is_solved_with_pivots():
    rng = np.random.default_rng(0)
    for size in (1, 3, 6):
        matrix, right = rng.normal(size=(size, size)), rng.normal(size=size)
        matrix[0, 0] = 0.0 if size > 1 else 1.0
        expected = np.linalg.solve(matrix, right)
        solve_in_place(matrix, right)
        np.testing.assert_allclose(right, expected, rtol=1e-10)


def test_shapes_that_do_not_fit_are_refused_when_compiled():
    @njit
    def wrong(matrices):
        multiply(matrices.product, matrices.b, matrices.squares)

    with pytest.raises(TypingError, match="multiply: shapes do not fit"):
        wrong(product_matrices(3, 5, 7))


def test_arrays_outside_records_are_refused():
    @njit
    def wrong(a, b, target):
        multiply(a, b, target)

    with pytest.raises(TypingError, match="fields of records"):
        wrong(np.eye(2), np.eye(2), np.eye(2))
