"""The least noise that the filter believes in: of sensors without any, its model's own errors are what is left.

The filter's steps are longer than the truth's and its derivatives those of one linearisation, so that readings of more
than these sds teach it errors of its own as if they were the patient. Below a half of the default encoders' noise its
alarm rings with no cause (24 patients, 30 s, still and moved in all three controls); without a disturbance its NEES/12
was above 1,000 with no floor of the wrench, and is 1 or less with this one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# Mouthpiece position (m), angles (rad), velocity (m/s), angular velocity (rad/s).
ENCODER_SDS = (0.05e-3, float(np.radians(0.05)), 0.5e-3, 0.01)
# Force (N) and moment (N m) of the wrench not known, in a tick.
WRENCH_SDS = (0.02, 0.0005)


def encoder_sds(device: Any) -> NDArray[np.float64]:
    """(12,) sds of the encoders' readings for a record of dtype ``DEVICE``, as the filter believes them."""
    names = ("encoder_position", "encoder_angle", "encoder_velocity", "encoder_rate")
    return np.repeat([max(float(device[name]), least) for name, least in zip(names, ENCODER_SDS, strict=True)], 3)


def wrench_variance(variance: NDArray[np.float64]) -> NDArray[np.float64]:
    """(6,) variance of the wrench not known, from that of the device."""
    least: NDArray[np.float64] = np.maximum(variance, np.repeat(np.square(WRENCH_SDS), 3))
    return least


def cell_repeats(cell_sd: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(6,) of which components of a load cell with these sds a repeated reading is no fault."""
    return np.equal(cell_sd, 0.0)
