"""What one measured point says about the jaw's pose: Young (2016), section 5.1, as printed.

Three numbers for five coordinates. Young: "By limiting the bounds, it is possible to find a unique solution". It is
not: the poses that put the point where it was measured are a surface of two dimensions, of which bounds cut out a
piece. What a search within bounds returns is one point of that piece, and depends on where the search began.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import lsq_linear, minimize

from jawenv.errors import InputError
from jawenv.estimation.thesis_methods.inverse_kinematics import N_COORDINATES, expected_measurements
from jawenv.mechanics.dynamics import N_STATES

Array = NDArray[np.float64]
# A miss of the point of so many metres weighs like a coordinate's way from bound to bound.
REACHED = 1e-8
STEPS = 6


def nearest_poses(
    jaw: Any, points: ArrayLike, lower: ArrayLike, upper: ArrayLike, start: ArrayLike
) -> tuple[Array, Array]:
    """Poses within bounds that put the mouthpiece at each of N points in turn, each the nearest to the one before.

    Near is meant in units of the bounds' widths. Where no pose within the bounds reaches the point, the nearest miss.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        points: (N, 3) measured places of the mouthpiece, head axes (m).
        lower: (5,) least x, y (m), theta, psi, alpha (rad).
        upper: (5,) greatest, above ``lower``.
        start: (5,) what the first pose is to be near to, within the bounds.

    Returns:
        (N, 5) poses and (N,) how far they put the mouthpiece from the points (m).

    Raises:
        InputError: a wrong shape, bounds in the wrong order, or a start outside them.
    """
    places = np.asarray(points, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 3 or not np.isfinite(places).all():
        raise InputError(f"points has shape {places.shape}, allowed is (N, 3), finite")
    low, high = _bounds(lower, upper)
    pose = np.array(start, dtype=np.float64)
    if pose.shape != (N_COORDINATES,) or not ((low <= pose) & (pose <= high)).all():
        raise InputError(f"start is {pose.tolist()}, allowed are five numbers within the bounds")
    width = high - low
    poses, misses = np.empty((len(places), N_COORDINATES)), np.empty(len(places))
    for n, place in enumerate(places):
        before = pose
        for _ in range(STEPS):
            reached, rows = mouthpiece(jaw, pose)
            # In units of the widths: the way from the pose before, and the point as good as exactly.
            matrix = np.vstack([np.eye(N_COORDINATES), rows * width / REACHED])
            right = np.concatenate([(before - pose) / width, (place - reached) / REACHED])
            step = lsq_linear(matrix, right, ((low - pose) / width - 1e-12, (high - pose) / width + 1e-12), "bvls")
            pose = np.clip(pose + width * step.x, low, high)
        poses[n], misses[n] = pose, np.linalg.norm(mouthpiece(jaw, pose)[0] - place)
    return poses, misses


def compatible_range(jaw: Any, pose: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> Array:
    """How far each coordinate can be from what it is in a pose, within bounds, with the mouthpiece at the same place.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        pose: (5,) within the bounds.
        lower: (5,) least x, y (m), theta, psi, alpha (rad).
        upper: (5,) greatest.

    Returns:
        (5, 2) least and greatest value of each coordinate among the poses that the same point is compatible with.

    Raises:
        InputError: bounds in the wrong order, or a search that did not end.
    """
    low, high = _bounds(lower, upper)
    width, start = high - low, np.asarray(pose, dtype=np.float64)
    place, rows = mouthpiece(jaw, start)
    size = np.linalg.norm(rows * width)  # of the way that the point can go, so that the constraint is of order 1
    constraint = {
        "type": "eq",
        "fun": lambda z: (mouthpiece(jaw, low + width * z)[0] - place) / size,
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
                raise InputError(f"pose is {start.tolist()}: {result.message}; allowed is a pose within the bounds")
            extremes[i, side] = low[i] + width[i] * result.x[i]
    return extremes


def null_directions(jaw: Any, pose: ArrayLike, scale: ArrayLike) -> tuple[Array, Array]:
    """The directions of pose that the mouthpiece's place does not show, by singular values of its 3 x 5 Jacobian.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        pose: (5,).
        scale: (5,) how much of each coordinate counts as one: metres and radians have no common measure.

    Returns:
        (2, 5) orthogonal directions of the scaled coordinates, times ``scale``: motions that leave the point, and
        (3,) the Jacobian's singular values (m), in falling order.
    """
    units = np.asarray(scale, dtype=np.float64)
    _, values, directions = np.linalg.svd(mouthpiece(jaw, np.asarray(pose, dtype=np.float64))[1] * units)
    return directions[3:] * units, values


def mouthpiece(jaw: Any, pose: Array) -> tuple[Array, Array]:
    """(3,) place of the mouthpiece in head axes (m), and (3, 5) its derivative by the pose."""
    state = np.zeros((1, N_STATES))
    state[0, :N_COORDINATES] = pose
    expected, rows, _ = expected_measurements(jaw, state)
    return expected[0, :3], rows[0, :3, :N_COORDINATES]


def _bounds(lower: ArrayLike, upper: ArrayLike) -> tuple[Array, Array]:
    low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    if low.shape != (N_COORDINATES,) or high.shape != (N_COORDINATES,) or not (low < high).all():
        raise InputError(f"lower is {low.tolist()}, upper {high.tolist()}; allowed: five numbers each, lower < upper")
    return low, high
