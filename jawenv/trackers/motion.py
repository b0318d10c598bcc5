"""The body ``jaw`` of a tracker's file as columns of a recording."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.recordings.columns import ENCODERS
from jawenv.trackers.tracks import Array, Tracks

BODY = "jaw"


def encoder_columns(tracks: Tracks) -> dict[str, Array]:
    """The columns of place (mm) and angles (deg) of a recording, by name; the most moved in opening first."""
    turned = tracks.rotations[BODY]
    seen = np.isfinite(turned).all(axis=(1, 2))
    angles = np.full((len(turned), 3), np.nan)
    angles[seen] = Rotation.from_matrix(turned[seen]).as_euler("YZX", degrees=True)
    x, y, z, pitch, yaw, roll = (column.name for column in ENCODERS[:6])
    places = tracks.places[BODY].T
    return {z: places[2], pitch: angles[:, 0], x: places[0], y: places[1], yaw: angles[:, 1], roll: angles[:, 2]}
