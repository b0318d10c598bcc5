"""What the kernels need to know about one jaw, as one record of numbers in SI units."""

from __future__ import annotations

from math import cos, pi, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Fossa, Mandible, MuscleSet, default_fossa, default_mandible, muscle_set

N_MUSCLES = 6
N_PARAMETERS = 2 * N_MUSCLES
N_TEETH = 3

JAW = np.dtype(
    [
        ("mass", "f8"),
        ("centre_of_mass", "f8", 3),
        ("inertia", "f8", (3, 3)),  # about the centre of mass
        ("inertia_inverse", "f8", (3, 3)),
        ("inertia_contact", "f8", (3, 3)),  # about the contact point: I - m [rho_c]x [rho_c]x
        ("inertia_contact_inverse", "f8", (3, 3)),
        ("gravity", "f8", 3),  # acceleration in head axes
        ("fossa_drop", "f8"),
        ("fossa_frequency", "f8"),
        ("damping_rotation", "f8"),
        ("damping_sliding", "f8"),
        ("tooth_stiffness", "f8"),
        ("condyle_stiffness", "f8"),
        ("condyle_half_width", "f8"),  # the condyles' centres lie at (0, +-it, 0) in body axes
        ("disc_stiffness", "f8"),  # of each condyle's disc
        ("disc_damping", "f8"),
        ("disc_onset", "f8"),
        ("stop_width", "f8"),
        ("crest", "f8"),  # x of the eminence's crest, where the anterior stop begins
        ("teeth", "f8", (N_TEETH, 3)),
        ("mouthpiece", "f8", 3),
        ("origin", "f8", (N_MUSCLES, 3)),
        ("insertion", "f8", (N_MUSCLES, 3)),
        ("l_o", "f8", N_MUSCLES),
    ],
    align=True,
)

# Grade G: the capsule that keeps the condyle on its path, soft enough for the integration step.
CONDYLE_STIFFNESS = 4000.0
STOP_WIDTH = 0.5e-3


def build_jaw(
    muscles: MuscleSet | None = None,
    mandible: Mandible | None = None,
    fossa: Fossa | None = None,
    *,
    head_tilt_deg: float = 0.0,
) -> Any:
    """Gather anatomy into the record that the kernels read.

    Args:
        muscles: Lines of action in the order of ``MUSCLE_NAMES``; the 12-parameter set by default.
        mandible: Mass properties, contact points and damping; the default mandible by default.
        fossa: Condylar path; the default fossa by default.
        head_tilt_deg: Pitch of the head, positive looking down; turns gravity in head axes (degrees).

    Returns:
        A ``numpy`` record of dtype ``JAW``.
    """
    muscles = muscles or muscle_set()
    mandible = mandible or default_mandible()
    fossa = fossa or default_fossa()
    jaws = np.zeros(1, dtype=JAW)
    jaw = jaws[0]
    rho = np.asarray(mandible.centre_of_mass_m, dtype=float)
    inertia = np.asarray(mandible.inertia_kg_m2, dtype=float)
    about_contact = inertia + mandible.mass_kg * (rho @ rho * np.eye(3) - np.outer(rho, rho))
    jaw["mass"] = mandible.mass_kg
    jaw["centre_of_mass"] = rho
    jaw["inertia"] = inertia
    jaw["inertia_inverse"] = np.linalg.inv(inertia)
    jaw["inertia_contact"] = about_contact
    jaw["inertia_contact_inverse"] = np.linalg.inv(about_contact)
    jaw["gravity"] = gravity_in_head(mandible.gravity, head_tilt_deg)
    jaw["fossa_drop"] = fossa.drop_m
    jaw["fossa_frequency"] = fossa.spatial_frequency
    jaw["damping_rotation"] = mandible.damping_rotation
    jaw["damping_sliding"] = mandible.damping_sliding
    jaw["tooth_stiffness"] = mandible.tooth_stiffness
    jaw["condyle_stiffness"] = CONDYLE_STIFFNESS
    jaw["condyle_half_width"] = mandible.condyle_half_width_m
    jaw["disc_stiffness"] = mandible.disc_stiffness
    jaw["disc_damping"] = mandible.disc_damping
    jaw["disc_onset"] = mandible.disc_onset
    jaw["stop_width"] = STOP_WIDTH
    jaw["crest"] = pi / fossa.spatial_frequency
    jaw["teeth"] = mandible.teeth_m
    jaw["mouthpiece"] = mandible.mouthpiece_m
    jaw["origin"] = muscles.origin_m
    jaw["insertion"] = muscles.insertion_m
    jaw["l_o"] = muscles.l_o_m
    return jaw


def gravity_in_head(gravity: float, head_tilt_deg: float) -> NDArray[np.float64]:
    """Gravity's acceleration (m/s2) in head axes when the head is pitched down by ``head_tilt_deg``."""
    tilt = radians(head_tilt_deg)
    return gravity * np.array([sin(tilt), 0.0, -cos(tilt)])
