"""The jaw's poses that one measured point allows: Young (2016), section 5.1, as printed.

Three numbers for five coordinates. Young: "By limiting the bounds, it is possible to find a unique solution". There is
none: the poses that put the point at the measured position form a two-dimensional surface, of which the bounds cut out
a piece. A search within bounds returns one point of that piece, which depends on its start.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize

from eval.thesis.methods.inverse_kinematics import N_COORDINATES, expected_measurements
from jawenv.base.errors import InputError
from jawenv.mechanics.dynamics import N_STATES

Array = NDArray[np.float64]


def compatible_range(jaw: Any, pose: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> Array:
    """Largest distance of each coordinate from a pose, within bounds, with the mouthpiece at the same place.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        pose: (5,) within the bounds.
        lower: (5,) least x, y (m), theta, psi, alpha (rad).
        upper: (5,) greatest.

    Returns:
        (5, 2) least and greatest value of each coordinate among the poses that the same point is compatible with.
    """
    low, high, start = (np.asarray(values, dtype=np.float64) for values in (lower, upper, pose))
    width = high - low
    point, rows = mouthpiece(jaw, start)
    size = np.linalg.norm(rows * width)  # of the way that the point can go, so that the constraint is of order 1
    constraint = {
        "type": "eq",
        "fun": lambda z: (mouthpiece(jaw, low + width * z)[0] - point) / size,
        "jac": lambda z: mouthpiece(jaw, low + width * z)[1] * width / size,
    }
    extremes = np.empty((N_COORDINATES, 2))
    for i in range(N_COORDINATES):
        for side, sign in enumerate((1.0, -1.0)):
            gradient = sign * np.eye(N_COORDINATES)[i]
            result = minimize(
                lambda z, g=gradient: g @ z,
                (start - low) / width,
                jac=lambda z, g=gradient: g,
                bounds=[(0.0, 1.0)] * N_COORDINATES,
                constraints=constraint,
                method="SLSQP",
                options={"ftol": 1e-9},
            )
            if not result.success:
                raise InputError(f"pose is {start.tolist()}: {result.message}; allowed: a pose within the bounds")
            extremes[i, side] = low[i] + width[i] * result.x[i]
    return extremes


def mouthpiece(jaw: Any, pose: Array) -> tuple[Array, Array]:
    """(3,) place of the mouthpiece in head axes (m), and (3, 5) its derivative by the pose."""
    state = np.zeros((1, N_STATES))
    state[0, :N_COORDINATES] = pose
    expected, rows, _ = expected_measurements(jaw, state)
    return expected[0, :3], rows[0, :3, :N_COORDINATES]
