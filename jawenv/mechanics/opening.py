"""The mouth's opening and the lengths of the muscle lines at a pose."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.mechanics.kinematics import contact_point, rotation


def opening_of(jaw: Any, pose: NDArray[np.float64]) -> float:
    """Distance of the mouthpiece below its place in the closed jaw (m), at a pose (5,)."""
    place = np.array(contact_point(jaw, tuple(pose))) + np.array(rotation(tuple(pose))) @ jaw["mouthpiece"]
    return float(jaw["mouthpiece"][2] - place[2])


def muscle_lengths(jaw: Any, pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lengths (lines,) of the muscle lines, m, at a pose (5,)."""
    insertions = np.array(contact_point(jaw, tuple(pose))) + jaw["insertion"] @ np.array(rotation(tuple(pose))).T
    lengths: NDArray[np.float64] = np.linalg.norm(jaw["origin"] - insertions, axis=-1)
    return lengths
