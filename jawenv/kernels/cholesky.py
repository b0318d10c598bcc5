"""Solutions and determinants by a Cholesky factor, for matrices of any size, and by elimination for other ones.

A *factor* is what ``linalg.decompose`` leaves of a symmetric positive definite matrix L L^T: L in the lower half, with
the inverse of its diagonal on the diagonal, so that nothing is divided by it. ``linalg.whiten`` solves for all columns
of a matrix.
"""

from __future__ import annotations

from math import log, sqrt

from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import decompose

ROUNDING = 1e-13  # of a diagonal entry, below which a pivot counts as zero


@njit
def set_root(matrix, root):
    """Lower triangular C with C C^T = ``matrix``, which is positive semidefinite up to rounding; C has its diagonal."""
    size = matrix.shape[0]
    for j in range(size):
        for i in range(size):
            root[i, j] = 0.0
        value = matrix[j, j]
        for k in range(j):
            value -= root[j, k] * root[j, k]
        if value > ROUNDING * matrix[j, j]:
            root[j, j] = sqrt(value)
            for i in range(j + 1, size):
                value = matrix[i, j]
                for k in range(j):
                    value -= root[i, k] * root[j, k]
                root[i, j] = value / root[j, j]


@njit
def log_det(factor):
    """Logarithm of the determinant of a matrix with this Cholesky factor."""
    value = 0.0
    for i in range(factor.shape[0]):
        value -= 2.0 * log(factor[i, i])
    return value


@njit
def solve_lower(factor, right):
    """``right`` (n) <- L^-1 ``right`` with a Cholesky factor."""
    for i in range(right.shape[0]):
        value = right[i]
        for k in range(i):
            value -= factor[i, k] * right[k]
        right[i] = value * factor[i, i]


@njit
def solve_decomposed(factor, right):
    """``right`` (n) <- (L L^T)^-1 ``right`` with a Cholesky factor."""
    solve_lower(factor, right)
    for i in range(right.shape[0] - 1, -1, -1):
        value = right[i]
        for k in range(i + 1, right.shape[0]):
            value -= factor[k, i] * right[k]
        right[i] = value * factor[i, i]


@njit
def invert_positive(matrix, inverse):
    """Inverse of a symmetric positive definite matrix; False if it is not positive definite.

    The lower half of ``matrix`` is overwritten by the inverse of its Cholesky factor.
    """
    size = matrix.shape[0]
    if not decompose(matrix):
        return False
    for j in range(size):
        for i in range(j + 1, size):
            value = 0.0
            for k in range(j, i):
                value -= matrix[i, k] * matrix[k, j]
            matrix[i, j] = value * matrix[i, i]
    for i in range(size):
        for j in range(i + 1):
            value = 0.0
            for k in range(i, size):
                value += matrix[k, i] * matrix[k, j]
            inverse[i, j] = value
            inverse[j, i] = value
    return True


@njit
def solve_in_place(matrix, right):
    """Solve a square system in place by elimination with row pivoting; the solution replaces ``right``."""
    n = right.shape[0]
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if pivot != k:
            for j in range(n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            right[k], right[pivot] = right[pivot], right[k]
        for i in range(k + 1, n):
            factor = matrix[i, k] / matrix[k, k]
            for j in range(k, n):
                matrix[i, j] -= factor * matrix[k, j]
            right[i] -= factor * right[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
