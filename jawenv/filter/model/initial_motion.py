"""Prior of the filter's motion before the first reading."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

PLACE_SD, ANGLE_SD, VELOCITY_SD, RATE_SD = 1e-3, 0.0175, 1e-3, 0.01  # 1 mm, 1 degree, 1 mm/s, 0.01 rad/s


def start_sd(jaw: Any, condyles: int) -> NDArray[np.float64]:
    """(n,) sds of (q, u): places come first, then three angles, and so for the speeds; 0 for what is held.

    Args:
        jaw: Record of a jaw.
        condyles: Number of the condyles in the filter's model.
    """
    places, angles, rates = [True, True, True], [True, True, True], [True, True, True]
    if condyles != 2:
        # Pitch (theta, and the second of the angular velocities) is always free, yaw and roll both or none.
        turns = bool(jaw["inertia_contact_inverse"][2, 2] > 0.0)
        places = [bool(jaw["free_x"]), bool(jaw["free_y"])]
        angles, rates = [True, turns, turns], [turns, True, turns]
    free = np.array([*places, *angles, *places, *rates])
    sizes = [len(places), 3, len(places), 3]
    sds: NDArray[np.float64] = free * np.repeat([PLACE_SD, ANGLE_SD, VELOCITY_SD, RATE_SD], sizes)
    return sds
