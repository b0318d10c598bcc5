"""Vectors in space as tuples of three floats, rotations as tuples of three rows: nothing is allocated."""

from __future__ import annotations

from math import sqrt
from typing import TypeAlias

from jawenv.kernels.compiled import njit_inlined

Vector: TypeAlias = tuple[float, float, float]
Matrix: TypeAlias = tuple[Vector, Vector, Vector]


@njit_inlined
def add(a: Vector, b: Vector) -> Vector:
    """Sum a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@njit_inlined
def subtract(a: Vector, b: Vector) -> Vector:
    """Difference a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@njit_inlined
def scale(s: float, a: Vector) -> Vector:
    """Product of the number s and the vector a."""
    return (s * a[0], s * a[1], s * a[2])


@njit_inlined
def dot(a: Vector, b: Vector) -> float:
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit_inlined
def cross(a: Vector, b: Vector) -> Vector:
    """Vector product a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@njit_inlined
def norm(a: Vector) -> float:
    """Euclidean length."""
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@njit_inlined
def apply(m: Matrix, a: Vector) -> Vector:
    """Matrix times vector; for the rotation C^T: body to head axes."""
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


@njit_inlined
def apply_transposed(m: Matrix, a: Vector) -> Vector:
    """Transposed matrix times vector; for the rotation C^T: head to body axes."""
    return (
        m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2],
        m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2],
        m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2],
    )


@njit_inlined
def row3(array, i):
    """Row i of an (n, 3) array as a vector."""
    return (array[i, 0], array[i, 1], array[i, 2])


@njit_inlined
def vector3(array):
    """A (3,) array as a vector."""
    return (array[0], array[1], array[2])
