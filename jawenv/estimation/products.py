"""The small matrix products of the filter, in the order that the compiler makes vectors of."""

from __future__ import annotations

from jawenv.compiled import njit, njit_within


@njit_within
def multiply_row(left, i, right, product, inner, columns):
    """Row i of ``product``, its first ``columns``, = the first ``inner`` of row i of ``left`` times ``right``.

    Four rows of ``right`` at a time.
    """
    last = inner - inner % 4
    for j in range(columns):
        value = 0.0
        for k in range(last, inner):
            value += left[i, k] * right[k, j]
        product[i, j] = value
    for k in range(0, last, 4):
        a, b, c, d = left[i, k], left[i, k + 1], left[i, k + 2], left[i, k + 3]
        for j in range(columns):
            product[i, j] += a * right[k, j] + b * right[k + 1, j] + c * right[k + 2, j] + d * right[k + 3, j]


@njit
def multiply(left, right, product):
    """``product`` (n, m) = the first n columns of ``left`` times the first n rows and m columns of ``right``."""
    for i in range(product.shape[0]):
        multiply_row(left, i, right, product, product.shape[0], product.shape[1])


@njit
def transpose(matrix, turned):
    """``turned`` (m, n) = the transpose of ``matrix`` (n, m)."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            turned[j, i] = matrix[i, j]
