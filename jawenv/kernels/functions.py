"""Elementary functions that are compiled into their callers."""

from __future__ import annotations

from math import floor

from jawenv.kernels.compiled import njit_inlined

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
