"""The midline model's right-hand side for callers outside the kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.base.errors import InputError
from jawenv.mechanics.dynamics import acceleration_kernel


def acceleration(
    jaw: Any, q: ArrayLike, u: ArrayLike, log_parameters: ArrayLike, force: ArrayLike
) -> NDArray[np.float64]:
    """Accelerations u' of the midline model.

    Args:
        jaw: Record from ``jawenv.mechanics.build_jaw``; its stops and damping act if it has them.
        q: (5,) x, y (m), theta, psi, alpha (rad).
        u: (5,) x', y' (m/s), angular velocity in body axes (rad/s).
        log_parameters: (2 m,) natural logs of F_o (N) and b of the jaw's m muscles, in the order of
            ``PARAMETER_NAMES`` by default.
        force: (3,) force on the mouthpiece in body axes (N), or (6,) with its moment about the mouthpiece (N m).

    Returns:
        (5,) x'', y'' (m/s2) and angular acceleration in body axes (rad/s2).

    Raises:
        InputError: an argument has the wrong shape or is not finite.
    """
    coordinates = _checked("q", q, (5,))
    speeds = _checked("u", u, (5,))
    names = 1 + int(jaw["muscle"].max())
    muscles = np.exp(_checked("log_parameters", log_parameters, (2 * names,)).reshape(names, 2))[jaw["muscle"]]
    wrench = np.zeros(6)
    force_array = np.asarray(force, dtype=np.float64)
    if force_array.shape not in ((3,), (6,)):
        raise InputError(f"force has shape {force_array.shape}; allowed: (3,) or (6,)")
    wrench[: force_array.size] = _checked("force", force_array, force_array.shape)
    return np.array(acceleration_kernel(jaw, muscles, tuple(coordinates), tuple(speeds), tuple(wrench)))


def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != shape:
        raise InputError(f"{name} has shape {array.shape}; allowed: {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{name} is {array.tolist()}; allowed: finite numbers")
    return array
