"""The independent jaw of ``jawenv.mechanics.newton_euler``, and a derivative of any function.

Every function accepts complex numbers, so that complex-step differentiation (Squire & Trapp 1998) gives derivatives
exact to rounding.
"""

import numpy as np

from jawenv.mechanics.newton_euler import (  # noqa: F401  of the tests that import this module
    acceleration,
    angle_axes,
    contact,
    fossa,
    measurement,
    muscle_lengths,
    rotation,
    runge_kutta,
    state_rate,
    tensions,
)
from jawenv.references.numpy_model import IMAGINARY_STEP


def derivative(function, point):
    """Jacobian (n_out, n_in) of ``function``, which takes one point, at the real array ``point``; exact to rounding."""
    columns = []
    for j in range(len(point)):
        moved = np.array(point, dtype=complex)
        moved[j] += 1j * IMAGINARY_STEP
        columns.append(np.imag(function(moved)) / IMAGINARY_STEP)
    return np.column_stack(columns)
