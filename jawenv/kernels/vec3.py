"""Vectors as tuples of three floats, rotations as tuples of three rows, sine and cosine: nothing is allocated."""

from __future__ import annotations

from math import floor, sqrt
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


# pi / 2 in two parts, the first of which has zeros in its last bits: whole multiples of it are exact.
QUARTER, QUARTER_REST = 1.57079632673412561417e00, 6.07710050650619224932e-11
PER_QUARTER = 0.63661977236758138243


@njit_inlined
def sin_cos(x):
    """Sine and cosine of x, by fdlibm's polynomials about the nearest quarter turn: to two units in the last place.

    Without a branch, so that the compiler sees where two callers ask for the same angle. Beyond a million radians the
    result is no longer that of x, but a number.
    """
    quarters = floor(x * PER_QUARTER + 0.5)
    r = (x - quarters * QUARTER) - quarters * QUARTER_REST
    r = min(max(r, -1.0), 1.0)
    z = r * r
    w = z * z
    s = (8.33333333332248946124e-03 + z * -1.98412698298579493134e-04) + w * (
        (2.75573137070700676789e-06 + z * -2.50507602534068634195e-08) + w * 1.58969099521155010221e-10
    )
    c = (4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) + w * (
        (2.48015872894767294178e-05 + z * -2.75573143513906633035e-07)
        + w * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)
    )
    sine = r + r * z * (-1.66666666666666324348e-01 + z * s)
    cosine = (1.0 - 0.5 * z) + w * c
    quadrant = quarters - 4.0 * floor(0.25 * quarters)
    turned = quadrant == 1.0 or quadrant == 3.0
    first, second = (cosine, sine) if turned else (sine, cosine)
    return (-first if quadrant >= 2.0 else first), (-second if quadrant == 1.0 or quadrant == 2.0 else second)
