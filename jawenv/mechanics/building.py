"""The record of a jaw, made from its anatomy."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Fossa, Mandible, MuscleSet, default_fossa, default_mandible, muscle_set
from jawenv.base.errors import InputError
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.jaw import jaw_dtype

ALL_FREE = (True, True, True, True, True)
# Grade G: the capsule that keeps the condyle on its path, soft enough for the integration step.
CONDYLE_STIFFNESS = 4000.0
STOP_WIDTH = 0.5e-3


def build_jaw(
    muscles: MuscleSet | None = None,
    mandible: Mandible | None = None,
    fossa: Fossa | None = None,
    *,
    head_tilt_deg: float = 0.0,
    free: Sequence[bool] = ALL_FREE,
) -> Any:
    """Gather anatomy into the record that the kernels read.

    Args:
        muscles: Muscles and their lines of action; the 12-parameter set by default.
        mandible: Mass properties, contact points and damping; the default mandible by default.
        fossa: Condylar path; the default fossa by default.
        head_tilt_deg: Pitch of the head, positive looking down; turns gravity in head axes (degrees).
        free: Which of x, y, theta, psi, alpha can move; the others stay where they are. Rotations about axes other
            than theta's must be free both or none, for angles to stay put when their angular velocity does.

    Returns:
        A ``numpy`` record of dtype ``jaw_dtype(number of lines)``.
    """
    muscles = muscles or muscle_set()
    mandible = mandible or default_mandible()
    fossa = fossa or default_fossa()
    if free[3] != free[4]:
        raise InputError(f"free is {tuple(free)}; allowed: psi and alpha free both or none")
    jaw = record_zeros(1, jaw_dtype(len(muscles.muscle)))[0]
    parts = _body(mandible) | _path(fossa) | _contacts(mandible) | _lines(muscles, mandible)
    for name, value in parts.items():
        jaw[name] = value
    # Body axes 1, 2, 3 turn roll, pitch and yaw.
    turns = np.flatnonzero([free[4], free[2], free[3]])
    rho = jaw["centre_of_mass"]
    about_contact = jaw["inertia"] + mandible.mass_kg * (rho @ rho * np.eye(3) - np.outer(rho, rho))
    jaw["inertia_contact_inverse"][np.ix_(turns, turns)] = np.linalg.inv(about_contact[np.ix_(turns, turns)])
    jaw["free_x"], jaw["free_y"] = free[0], free[1]
    jaw["gravity"] = gravity_in_head(mandible.gravity, head_tilt_deg)
    return jaw


def _body(mandible: Mandible) -> dict[str, Any]:
    return {
        "mass": mandible.mass_kg,
        "centre_of_mass": mandible.centre_of_mass_m,
        "inertia": mandible.inertia_kg_m2,
        "damping_rotation": mandible.damping_rotation,
        "damping_sliding": mandible.damping_sliding,
        "mouthpiece": mandible.mouthpiece_m,
        "mouthpiece_mobility": _largest_mobility(mandible, np.asarray(mandible.mouthpiece_m)),
    }


def _path(fossa: Fossa) -> dict[str, Any]:
    return {"fossa_drop": fossa.drop_m, "fossa_frequency": fossa.spatial_frequency, "crest": fossa.crest_m}


def _contacts(mandible: Mandible) -> dict[str, Any]:
    return {
        "teeth": mandible.teeth_m,
        "tooth_stiffness": mandible.tooth_stiffness,
        "tooth_mobility": mobility(mandible, mandible.teeth_m, np.array([0.0, 0.0, 1.0])),
        "stop_width": STOP_WIDTH,
        "condyle_stiffness": CONDYLE_STIFFNESS,
        "condyle_half_width": mandible.condyle_half_width_m,
        "condyle_mobility": mobility(mandible, np.zeros(3), np.array([1.0, 0.0, 0.0])),
        "disc_stiffness": mandible.disc_stiffness,
        "disc_damping": mandible.disc_damping,
    }


def _lines(muscles: MuscleSet, mandible: Mandible) -> dict[str, Any]:
    directions = (muscles.origin_m - muscles.insertion_m) / muscles.l_o_m[:, None]
    return {
        "muscle": muscles.muscle,
        "origin": muscles.origin_m,
        "insertion": muscles.insertion_m,
        "l_o": muscles.l_o_m,
        "tone": mandible.closing_tone_N * muscles.whole_muscles_per_line,
        "mobility": mobility(mandible, muscles.insertion_m, directions),
    }


def mobility(mandible: Mandible, points: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Acceleration (m/s2) of points (..., 3) of a free mandible along unit vectors, for 1 N along them, jaw closed."""
    turn = np.cross(points - mandible.centre_of_mass_m, directions)
    solved = turn @ np.linalg.inv(mandible.inertia_kg_m2).T
    result: NDArray[np.float64] = 1.0 / mandible.mass_kg + np.sum(turn * solved, axis=-1)
    return result


def _largest_mobility(mandible: Mandible, point: NDArray[np.float64]) -> float:
    """``mobility`` of a point (3,) in the direction that has the largest."""
    turns = np.cross(point - mandible.centre_of_mass_m, np.eye(3))
    mobilities = np.eye(3) / mandible.mass_kg + turns @ np.linalg.solve(mandible.inertia_kg_m2, turns.T)
    return float(np.linalg.eigvalsh(mobilities)[-1])


def gravity_in_head(gravity: float, head_tilt_deg: float) -> NDArray[np.float64]:
    """Gravity's acceleration (m/s2) in head axes when the head is pitched down by ``head_tilt_deg``."""
    tilt = radians(head_tilt_deg)
    return gravity * np.array([sin(tilt), 0.0, -cos(tilt)])
