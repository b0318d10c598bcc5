"""Regressors of the filter: the wrench at the mouthpiece per unit of each tension coefficient.

Lines of action are taken half way through the filter's tick.
"""

from __future__ import annotations

from math import exp

from jawenv.filter.model.basis import Basis
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, norm, row3, scale, subtract, vector3
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, rotation


@njit
def middle_of(jaw: Jaw, before, after):
    """The pose half way between two states, as the midline model's five coordinates, and the reference point there."""
    angles = after.shape[0] // 2 - 3  # number of the first
    pose = (
        0.5 * (before[0] + after[0]),
        0.5 * (before[1] + after[1]),
        0.5 * (before[angles] + after[angles]),
        0.5 * (before[angles + 1] + after[angles + 1]),
        0.5 * (before[angles + 2] + after[angles + 2]),
    )
    if jaw.condyles == 2:
        return pose, (pose[0], pose[1], 0.5 * (before[2] + after[2]))
    return pose, contact_point(jaw, pose)


@njit
def set_line_wrenches(jaw: Jaw, basis: Basis, trend, pose, position, line_wrench):
    """Into ``line_wrench`` (6, columns) the wrench (body axes) of each coefficient, and the gain error's, ``trend``.

    ``pose`` and ``position`` are those of ``middle_of``. A line's wrench is one direction times the basis functions of
    its muscle at its strain.
    """
    nodes = basis.nodes.shape[1]
    line_wrench[:, :] = 0.0
    for k in range(N_WRENCH):
        line_wrench[k, basis.nodes.shape[0] * nodes] = trend[k]
    body_to_head, mouthpiece = rotation(pose), vector3(jaw.mouthpiece)
    for line in range(jaw.origin.shape[0]):
        insertion = row3(jaw.insertion, line)
        reach = subtract(row3(jaw.origin, line), add(position, apply(body_to_head, insertion)))
        length = norm(reach)
        pull = apply_transposed(body_to_head, scale(1.0 / length, reach))
        turn = cross(subtract(insertion, mouthpiece), pull)
        muscle = jaw.muscle[line]
        strain = length / jaw.l_o[line] - 1.0 - basis.centre[muscle]
        for k in range(nodes):
            share, column = exp(basis.nodes[muscle, k] * strain), muscle * nodes + k
            for i in range(3):
                line_wrench[i, column] += share * pull[i]
                line_wrench[3 + i, column] += share * turn[i]
