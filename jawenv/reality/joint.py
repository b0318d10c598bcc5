"""Tissue of the joint that stiffens near the ends of its range, and bands that are no closing muscle.

The joint's are one-sided springs at the mouthpiece. A scar is one on the left side, slack until it is a tenth longer
than with the jaw closed. The openers and the lateral pterygoids have the passive law of the closers, F_o exp(b (l / l_o
- 1)), with ``OTHER_B`` and the closed jaw's length as l_o.
"""

from __future__ import annotations

from math import exp

import numpy as np

from jawenv.device.comfort import Limits, excursions
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, norm, row3, scale, subtract, vector3
from jawenv.mechanics.forces import smooth_ramp
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, rotation
from jawenv.reality.options import RealityRecord

# m, head and body axes as of the attachments (G): scar from the tuber of the maxilla to the oblique line; digastric and
# geniohyoid as one line from the hyoid to the inner chin; lateral pterygoid from its plate to the neck of the condyle.
ORIGIN = np.array(
    [
        (0.045, 0.030, -0.015),
        (0.045, 0.006, -0.085),
        (0.045, -0.006, -0.085),
        (0.030, 0.025, -0.005),
        (0.030, -0.025, -0.005),
    ]
)
INSERTION = np.array(
    [
        (0.050, 0.030, -0.045),
        (0.085, 0.005, -0.070),
        (0.085, -0.005, -0.070),
        (-0.002, 0.046, -0.006),
        (-0.002, -0.046, -0.006),
    ]
)
OTHER_B = 7.0
SCAR_SLACK = 1.1  # of its length with the jaw closed
SCAR_ONSET = 1e-3  # m over which its stiffness begins
CLOSED = (0.0, 0.0, 0.0, 0.0, 0.0)
NO_PUSH = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@njit
def _line_from(jaw: Jaw, i, q, lift):
    """Vector from the insertion of line i to its origin (m, head axes)."""
    contact = add(contact_point(jaw, q), (0.0, 0.0, lift[0]))
    return subtract(row3(ORIGIN, i), add(contact, apply(rotation(q), row3(INSERTION, i))))


@njit
def _band_tension(reality: RealityRecord, jaw: Jaw, i, length):
    """Tension (N) of line i with this ``length`` (m)."""
    closed = norm(_line_from(jaw, i, CLOSED, (0.0, 0.0)))
    if i == 0:
        ramp, _ = smooth_ramp(length - SCAR_SLACK * closed, SCAR_ONSET)
        return reality.scar_stiffness * ramp
    return reality.other_muscles_force * exp(OTHER_B * (length / closed - 1.0))


@njit
def bands_push(reality: RealityRecord, jaw: Jaw, q, lift):
    """Force (N) and moment (N m) of all lines at the mouthpiece, body axes, as a device's wrench is.

    Args:
        reality: Record of dtype ``REALITY``.
        jaw: The truth's record.
        q: Coordinates (x, y, theta, psi, alpha).
        lift: Of the condyles' midpoint above its path (m), and its rate.
    """
    force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if reality.scar_stiffness == 0.0 and reality.other_muscles_force == 0.0:
        return NO_PUSH
    body_to_head = rotation(q)
    for i in range(ORIGIN.shape[0]):
        line = _line_from(jaw, i, q, lift)
        length = norm(line)
        pull = apply_transposed(body_to_head, scale(_band_tension(reality, jaw, i, length) / length, line))
        force = add(force, pull)
        moment = add(moment, cross(subtract(row3(INSERTION, i), vector3(jaw.mouthpiece)), pull))
    return (force[0], force[1], force[2], moment[0], moment[1], moment[2])


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
