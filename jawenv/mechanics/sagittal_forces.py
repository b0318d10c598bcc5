"""Forces on the mandible in the sagittal plane, where the condyle need not lie on its path."""

from __future__ import annotations

from typing import Any

from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import apply, vector3
from jawenv.mechanics.forces import capsule_force, carried_forces
from jawenv.mechanics.kinematics import rotation

Six = tuple[float, float, float, float, float, float]


@njit
def turned(point: Any, theta: float) -> tuple[float, float]:
    """Forward and upward arm from the condyle's centre to a body ``point`` (3) when the jaw is open by theta."""
    arm = apply(rotation((0.0, 0.0, theta, 0.0, 0.0)), vector3(point))
    return arm[0], arm[2]


@njit
def passive_forces(jaw: Any, muscles: Any, state: Six) -> tuple[float, float, float]:
    """Force forward and up (N) and moment about +y (N m) about the condyle's centre, of all but device and contact.

    ``muscles`` (n, 2) belongs to the first n lines; ``state`` is x, z, theta, x', z', theta'. The capsule holds the
    condyle in front of the crest; behind x = 0 the fossa's wall comes first.
    """
    x, z, theta, x_rate, z_rate, theta_rate = state
    force, moment = carried_forces(jaw, muscles, (x, 0.0, z), rotation((x, 0.0, theta, 0.0, 0.0)))
    capsule, _ = capsule_force(jaw, x)
    c = jaw.damping_sliding
    return force[0] + capsule - c * x_rate, force[2] - c * z_rate, moment[1] - jaw.damping_rotation * theta_rate
