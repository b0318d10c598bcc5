"""What each coefficient's tension does at the mouthpiece, and what the score owes to the noise in it.

Lines of action are taken half way through the filter's step.
"""

from __future__ import annotations

import numpy as np

from jawenv.compiled import njit
from jawenv.estimation.calibrated_strain import calibrate
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.kinematics import contact_point, fossa, turning_axes
from jawenv.mechanics.vec3 import add, apply, apply_transposed, cross, dot, norm, row3, scale, subtract, vector3


@njit
def middle_of(jaw, before, after):
    """The pose half way between two states, as the midline model's five coordinates, and the reference point there."""
    if jaw.condyles == 2:
        q = (
            0.5 * (before[0] + after[0]),
            0.5 * (before[1] + after[1]),
            0.5 * (before[3] + after[3]),
            0.5 * (before[4] + after[4]),
            0.5 * (before[5] + after[5]),
        )
        return q, (q[0], q[1], 0.5 * (before[2] + after[2]))
    q = (
        0.5 * (before[0] + after[0]),
        0.5 * (before[1] + after[1]),
        0.5 * (before[2] + after[2]),
        0.5 * (before[3] + after[3]),
        0.5 * (before[4] + after[4]),
    )
    return q, contact_point(jaw, q)


@njit
def set_by_place(jaw, q, body_to_head, scratch):
    """Into ``by_place`` (n / 2, 3), by what the reference point moves with each coordinate (body axes).

    The last three rows, those of the angles, hold the axes about which they turn the body (body axes). Returns the
    direction along which the fossa turns an upward force as the condyles slide (body axes), and the upward direction.
    """
    by_place = scratch.by_place
    axes = turning_axes(q)
    _, slope, curvature, _ = fossa(jaw, q[0])
    first = by_place.shape[0] - 3
    forward = apply_transposed(body_to_head, (1.0, 0.0, 0.0))
    left = apply_transposed(body_to_head, (0.0, 1.0, 0.0))
    up = apply_transposed(body_to_head, (0.0, 0.0, 1.0))
    for j in range(3):
        by_place[0, j], by_place[1, j] = forward[j], left[j]
        if first == 2:
            by_place[0, j] += slope * up[j]
        else:
            by_place[2, j] = up[j]
    for i in range(3):
        for j in range(3):
            by_place[first + i, j] = axes[i][j]
    return scale(curvature if first == 2 else 0.0, forward), up


@njit
def line_spill(scratch, insertion, mouthpiece, pull, turn, length, bend):
    """What a line adds to the score through ``spilt`` (6, n) as it lengthens by a unit, and as it turns.

    And the covariance of its estimated length with that length's error, from ``halfway``.

    ``pull`` is the line's direction, ``turn`` its moment about the mouthpiece, ``insertion`` its point: body axes. A
    force that turns with the body acts the same on the turning, but not on the sliding, which is along axes of the
    head; so that both are one wrench, the moment is taken about the condyles.
    """
    by_place, spilt = scratch.by_place, scratch.spilt
    coordinates = by_place.shape[0]
    first = coordinates - 3
    by_strain, by_direction = 0.0, 0.0
    for c in range(coordinates):
        moved = row3(by_place, c)
        axis = (0.0, 0.0, 0.0)
        if c >= first:
            axis = moved
            moved = cross(axis, insertion)
        shortened = dot(pull, moved)
        force = scale(-1.0 / length, subtract(moved, scale(shortened, pull)))
        moment = cross(insertion, subtract(force, cross(axis, pull)))
        if c == 0:
            force = add(force, scale(dot(bend[1], pull), bend[0]))
        moment = subtract(moment, cross(mouthpiece, force))
        scratch.spare[c] = shortened
        for i in range(3):
            by_strain -= shortened * (pull[i] * spilt[i, c] + turn[i] * spilt[3 + i, c])
            by_direction += force[i] * spilt[i, c] + moment[i] * spilt[3 + i, c]
    shared = 0.0
    for c in range(coordinates):
        for d in range(coordinates):
            shared += scratch.spare[c] * scratch.spare[d] * scratch.halfway[c, d]
    return by_strain, by_direction, shared


@njit
def set_line_wrenches(jaw, belief, place, body_to_head, bend, dt, scratch):
    """Wrench at the mouthpiece (body axes) that each coefficient of unit size amounts to, and the gain error's.

    Lines are taken half way through the step of ``dt``, their strains are calibrated (``calibrated_strain``). The score
    is rid of what the load cell's noise gives it by way of them (``noisy_input``).
    """
    basis, score = belief.basis, belief.score
    nodes = basis.nodes.shape[1]
    line_wrench = scratch.line_wrench
    for k in range(N_WRENCH):
        for j in range(line_wrench.shape[1]):
            line_wrench[k, j] = 0.0
        line_wrench[k, line_wrench.shape[1] - 1] = scratch.reading[k]
    mouthpiece = vector3(jaw.mouthpiece)
    for line in range(jaw.origin.shape[0]):
        insertion = row3(jaw.insertion, line)
        reach = subtract(row3(jaw.origin, line), add(place, apply(body_to_head, insertion)))
        length = norm(reach)
        pull = apply_transposed(body_to_head, scale(1.0 / length, reach))
        turn = cross(subtract(insertion, mouthpiece), pull)
        muscle = jaw.muscle[line]
        by_strain, by_direction, shared = line_spill(scratch, insertion, mouthpiece, pull, turn, length, bend)
        shared /= jaw.l_o[line] * jaw.l_o[line]
        strain, kept = calibrate(length / jaw.l_o[line] - 1.0, shared, line, belief, dt)
        scratch.kept[line] = kept
        by_strain *= kept / jaw.l_o[line]
        for k in range(nodes):
            share = np.exp(basis.nodes[muscle, k] * (strain - basis.centre[muscle]))
            column = muscle * nodes + k
            score[column] += share * (basis.nodes[muscle, k] * by_strain + by_direction)
            for i in range(3):
                line_wrench[i, column] += share * pull[i]
                line_wrench[3 + i, column] += share * turn[i]
