"""The four channels in which a device is told where to move a jaw, as fractions of this patient's comfort."""

from __future__ import annotations

from typing import Annotated

from jawenv.kernels.records import Array, record_dtype

CHANNELS = ("opening", "side", "fore_aft", "roll")
N_CHANNELS = len(CHANNELS)
OPENING, SIDE, FORE_AFT, ROLL = range(N_CHANNELS)
LOWEST = (0.0, -1.0, -1.0, -1.0)
HIGHEST = 1.0
ROLL_FULL_SCALE_RAD = 0.07
# 1/s: rate at which the device moves a target, at most. On a typical patient 23 mm/s of opening and 18 mm/s of side.
FASTEST_TARGET = (0.9, 3.0, 1.5, 3.0)


class Tracker:
    """State of the law of targets."""

    target: Annotated[Array, N_CHANNELS]  # fractions, before the guard
    rate: Annotated[Array, N_CHANNELS]  # 1/s, at which they move
    size: Annotated[Array, N_CHANNELS]  # what the guard multiplies them by, 0 to 1
    integral: Annotated[Array, 3]  # of the force law: N, N m, N m
    rest_roll: float  # rad, as first seen
    crest: float  # m, the eminence's; 0 for that of the default anatomy
    full_force: float  # N, of the fore-aft channel
    begun: bool


TRACKER = record_dtype(Tracker)
"""The device's memory while it follows targets."""
