"""Forces on the mandible and their stiffness: muscles, gravity, teeth, capsule, damping on sliding.

Every force acts at a point that moves with the mandible, p from the contact point in head axes, and depends on
where that point is: dF = K dr. Summed over points, the resultant (F, tau about the contact point) and the three
3 x 3 matrices

    K,    L = sum [p]x K,    N = sum (p F^T - (p . F) 1 - [p]x K [p]x)

give the derivative for any motion: a shift dr changes F by K dr and tau by L dr; a turn dphi (head axes) changes F by
L^T dphi and tau by N dphi. Moments are taken about the contact point with arms measured from it.
"""

from __future__ import annotations

from math import exp

from jawenv.kernels.compiled import njit, njit_inlined
from jawenv.kernels.lanes import all_lines, total
from jawenv.kernels.vec3 import add, apply, cross, dot, norm, row3, scale, subtract, vector3
from jawenv.mechanics.jaw import N_TEETH, Jaw
from jawenv.mechanics.kinematics import contact_point, fossa


@njit_inlined
def smooth_ramp(depth, width):
    """Depth of a one-sided stop with a quadratic onset over ``width``, and its slope: continuous to the slope."""
    if depth <= 0.0:
        return 0.0, 0.0
    if depth < width:
        return 0.5 * depth * depth / width, depth / width
    return depth - 0.5 * width, 1.0


@njit_inlined
def muscle_pull(jaw: Jaw, muscles, i, contact, body_to_head):
    """Line i: arm of its insertion, unit direction of its pull, length, tension F_o exp(b (l - l_o)/l_o).

    Of all lines at once where ``i`` is ``all_lines`` of the jaw's (``kernels.lanes``).
    ``muscles`` is (lines, 2): F_o in N and b of each line. The law is van Ruijven & Weijs (1990) as used by Young
    (2016), eq. 2.2.
    """
    arm = apply(body_to_head, row3(jaw.insertion, i))
    line = subtract(row3(jaw.origin, i), add(contact, arm))
    length = norm(line)
    tension = muscles[i, 0] * exp(muscles[i, 1] * (length / jaw.l_o[i] - 1.0))
    return arm, scale(1.0 / length, line), length, tension


@njit_inlined
def totals(vectors):
    """Sum over all lines of a vector for each."""
    return (total(vectors[0]), total(vectors[1]), total(vectors[2]))


@njit_inlined
def carried_forces(jaw: Jaw, muscles, contact, body_to_head):
    """Resultant force and moment about ``contact``, head axes, of muscles, gravity and teeth.

    ``contact`` is where the body's reference point, midway between the condyles' centres, is in head axes (m).
    """
    weight = scale(jaw.mass, vector3(jaw.gravity))
    force = weight
    moment = cross(apply(body_to_head, vector3(jaw.centre_of_mass)), weight)
    arm, direction, _, tension = muscle_pull(jaw, muscles, all_lines(jaw.l_o), contact, body_to_head)
    pull = scale(tension + jaw.tone, direction)
    force = add(force, totals(pull))
    moment = add(moment, totals(cross(arm, pull)))
    for i in range(N_TEETH):
        arm = apply(body_to_head, row3(jaw.teeth, i))
        ramp, _ = smooth_ramp(contact[2] + arm[2] - jaw.teeth[i, 2], jaw.stop_width)
        if ramp > 0.0:
            push = (0.0, 0.0, -jaw.tooth_stiffness * ramp)
            force = add(force, push)
            moment = add(moment, cross(arm, push))
    return force, moment


@njit_inlined
def resultant(jaw: Jaw, muscles, q, u, body_to_head):
    """Resultant force and moment about the contact point, head axes, of everything but the device."""
    force, moment = carried_forces(jaw, muscles, contact_point(jaw, q), body_to_head)
    capsule, _ = capsule_force(jaw, q[0])
    _, slope, _, _ = fossa(jaw, q[0])
    c = jaw.damping_sliding
    force = add(force, (capsule - c * u[0], -c * u[1], -c * slope * u[0]))
    return force, moment


@njit_inlined
def capsule_force(jaw: Jaw, x):
    """Forward force of the stops behind the fossa's roof (x < 0) and past the crest, and its derivative by x."""
    back, back_slope = smooth_ramp(-x, jaw.stop_width)
    front, front_slope = smooth_ramp(x - jaw.crest, jaw.stop_width)
    k = jaw.condyle_stiffness
    return k * (back - front), -k * (back_slope + front_slope)


@njit
def _clear_stiffness(stiffness):
    """Set the (3, 3, 3) array of K, L, N to zero."""
    for m in range(3):
        for i in range(3):
            for j in range(3):
                stiffness[m, i, j] = 0.0


@njit_inlined
def _add_point(stiffness, arm, force):
    """Add a point force independent of place to N; here and below of one point, or of all lines at once."""
    along = total(dot(arm, force))
    for i in range(3):
        for j in range(3):
            stiffness[2, i, j] += total(arm[i] * force[j])
        stiffness[2, i, i] -= along


@njit_inlined
def _add_line(stiffness, arm, direction, k):
    """Add the symmetric rank-one stiffness k e e^T at ``arm`` to K, L and N."""
    turn = cross(arm, direction)
    pull, twist = scale(k, direction), scale(k, turn)
    for i in range(3):
        for j in range(3):
            stiffness[0, i, j] += total(pull[i] * direction[j])
            stiffness[1, i, j] += total(twist[i] * direction[j])
            stiffness[2, i, j] += total(twist[i] * turn[j])


@njit_inlined
def _add_isotropic(stiffness, arm, k):
    """Add the stiffness k 1 at ``arm`` to K, L and N."""
    lever = scale(k, arm)
    whole, square = total(k), total(dot(lever, arm))
    for i in range(3):
        stiffness[0, i, i] += whole
        for j in range(3):
            stiffness[2, i, j] -= total(lever[i] * arm[j])
        stiffness[2, i, i] += square
    x, y, z = totals(lever)
    stiffness[1, 0, 1] -= z
    stiffness[1, 0, 2] += y
    stiffness[1, 1, 0] += z
    stiffness[1, 1, 2] -= x
    stiffness[1, 2, 0] -= y
    stiffness[1, 2, 1] += x


@njit
def carried_with_stiffness(jaw: Jaw, muscles, contact, body_to_head, stiffness, pulls):
    """Force and moment of ``carried_forces``; sets ``stiffness`` (3, 3, 3) and ``pulls`` as well.

    ``pulls`` (lines, 7) receives per line its force, its moment about ``contact`` and its strain (l - l_o)/l_o.
    """
    weight = scale(jaw.mass, vector3(jaw.gravity))
    force = weight
    arm = apply(body_to_head, vector3(jaw.centre_of_mass))
    moment = cross(arm, weight)
    _clear_stiffness(stiffness)
    _add_point(stiffness, arm, weight)
    lines = all_lines(jaw.l_o)
    arm, direction, length, tension = muscle_pull(jaw, muscles, lines, contact, body_to_head)
    pull, whole = scale(tension, direction), scale(tension + jaw.tone, direction)
    turn = cross(arm, pull)
    force = add(force, totals(whole))
    moment = add(moment, totals(cross(arm, whole)))
    across = (tension + jaw.tone) / length
    _add_point(stiffness, arm, whole)
    _add_isotropic(stiffness, arm, -across)
    _add_line(stiffness, arm, direction, across - tension * muscles[lines, 1] / jaw.l_o[lines])
    for k in range(3):
        pulls[lines, k] = pull[k]
        pulls[lines, 3 + k] = turn[k]
    pulls[lines, 6] = length / jaw.l_o[lines] - 1.0
    for i in range(N_TEETH):
        tooth = apply(body_to_head, row3(jaw.teeth, i))
        ramp, steepness = smooth_ramp(contact[2] + tooth[2] - jaw.teeth[i, 2], jaw.stop_width)
        if ramp > 0.0:
            push = (0.0, 0.0, -jaw.tooth_stiffness * ramp)
            force = add(force, push)
            moment = add(moment, cross(tooth, push))
            _add_point(stiffness, tooth, push)
            _add_line(stiffness, tooth, (0.0, 0.0, 1.0), -jaw.tooth_stiffness * steepness)
    return force, moment


@njit
def resultant_with_stiffness(jaw: Jaw, muscles, q, u, body_to_head, stiffness, pulls):
    """Force and moment of ``resultant``; sets ``stiffness`` and ``pulls`` as ``carried_with_stiffness`` does."""
    contact = contact_point(jaw, q)
    force, moment = carried_with_stiffness(jaw, muscles, contact, body_to_head, stiffness, pulls)
    capsule, capsule_slope = capsule_force(jaw, q[0])
    stiffness[0, 0, 0] += capsule_slope
    _, slope, _, _ = fossa(jaw, q[0])
    c = jaw.damping_sliding
    force = add(force, (capsule - c * u[0], -c * u[1], -c * slope * u[0]))
    return force, moment
