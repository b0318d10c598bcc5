"""Tissue of the joint that stiffens near the ends of its range: one-sided springs at the mouthpiece."""

from __future__ import annotations

from jawenv.device.comfort import Limits, excursions
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, apply_transposed, vector3
from jawenv.mechanics.forces import smooth_ramp
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, rotation
from jawenv.reality.bands import bands_push
from jawenv.reality.options import RealityRecord


@njit
def articular_force(reality: RealityRecord, limits: Limits, jaw: Jaw, point):
    """Force (N, head axes, upwards and to the middle) on the mouthpiece at ``point`` (m, head axes).

    It begins at ``articular_onset`` of the painless range of opening, and of the soft limit of side motion, grows
    quadratically to its end, where the stiffness is the full one, and linearly beyond: it has a potential and is
    continuous with its slope.
    """
    opening, side, _ = excursions(limits, jaw, point)
    begin = reality.articular_onset * limits.opening
    ramp, _ = smooth_ramp(opening - begin, limits.opening - begin)
    begin = reality.articular_onset * limits.side
    aside, _ = smooth_ramp(abs(side) - begin, limits.side - begin)
    inwards = -reality.articular_side_stiffness * aside
    return (0.0, inwards if side > 0.0 else -inwards, reality.articular_stiffness * ramp)


@njit
def articular_push(reality: RealityRecord, limits: Limits, jaw: Jaw, q, lift):
    """``articular_force`` in body axes, as a device's wrench is, without moment; ``lift`` as in ``update_tissue``."""
    body_to_head = rotation(q)
    contact = add(contact_point(jaw, q), (0.0, 0.0, lift[0]))
    point = add(contact, apply(body_to_head, vector3(jaw.mouthpiece)))
    return apply_transposed(body_to_head, articular_force(reality, limits, jaw, point))


@njit
def tissue_push(reality: RealityRecord, limits: Limits, jaw: Jaw, q, lift):
    """Force (N) and moment (N m) of all tissue beside the closers at the mouthpiece, body axes."""
    push = bands_push(reality, jaw, q, lift)
    if reality.articular_stiffness == 0.0 and reality.articular_side_stiffness == 0.0:
        return push
    joint = articular_push(reality, limits, jaw, q, lift)
    return (push[0] + joint[0], push[1] + joint[1], push[2] + joint[2], push[3], push[4], push[5])
