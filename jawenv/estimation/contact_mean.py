"""How much more teeth and stops push on average than they would on the estimated jaw.

They push on one side alone, with an onset over half a millimetre (``smooth_ramp``), so that the mean of their force
over the motions that may be true is not their force at the mean. A jaw that trembles on its teeth shows the difference
in every tick: the estimate would be too far open or closed by half an sd, and what opens it passes for muscle force.
This is the second-order extended Kalman filter (Athans, Wishner & Bertolini 1968, IEEE Trans. Autom. Control 13:504),
for the contacts alone, which curve far more than the muscles.

With e = estimated less true motion, P its covariance and D its covariance with the estimate (``noisy_input``), the
force at the true motion is on average f + f'' : (P - 2 D) / 2, with f at the estimate. P - 2 D is called ``spread``.
"""

from __future__ import annotations

from math import erf, sqrt
from typing import Any

from jawenv.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import N_TEETH
from jawenv.mechanics.kinematics import contact_point, fossa, rotation, turning_axes
from jawenv.mechanics.vec3 import add, apply, apply_transposed, cross, dot, row3, scale, subtract, vector3

REACH = 1e-3  # m off its onset, beyond which a contact is left out
# Sd of the depth, in widths of the onset, from which on the mean is not asked for. Where a single point leaves the pose
# open, the motions that may be true are far from normal, and their mean led those patients astray who were nearly lost.
LARGEST_SD = 0.5


def contact_mean_fields(n_states: int) -> list[Any]:
    """Working memory of this file as fields of a dtype; ``unsure`` says whether the rest is set.

    ``start_cov`` and ``start_spread`` are those of the motion at the start of the step, ``wrench_cov`` and
    ``wrench_spread`` those of the wrench not known: constant over the step, and tilting.
    """
    return [
        ("unsure", "u1"),
        ("start_cov", "f8", (n_states, n_states)),
        ("start_spread", "f8", (n_states, n_states)),
        ("wrench_cov", "f8", (2 * N_WRENCH,)),
        ("wrench_spread", "f8", (2 * N_WRENCH,)),
        ("depth_row", "f8", (n_states + 2 * N_WRENCH,)),
    ]


@njit
def be_unsure(covariance, tremble, noise_variance, scratch):
    """Set what ``mean_push`` needs, from the motion's covariance P and ``tremble``, C = P - D.

    ``noise_variance`` (12) is that of the wrench not known: constant over the step, unmodelled and load-cell noise
    together; and tilting, the load cell's noise alone, which estimate and error share.
    """
    scratch.unsure = 1
    for i in range(covariance.shape[0]):
        for j in range(covariance.shape[0]):
            scratch.start_cov[i, j] = covariance[i, j]
            scratch.start_spread[i, j] = tremble[i, j] + tremble[j, i] - covariance[i, j]
    for k in range(N_WRENCH):
        scratch.wrench_cov[k] = noise_variance[k]
        scratch.wrench_cov[N_WRENCH + k] = noise_variance[N_WRENCH + k]
        scratch.wrench_spread[k] = noise_variance[k] - 2.0 * noise_variance[N_WRENCH + k]
        scratch.wrench_spread[N_WRENCH + k] = -noise_variance[N_WRENCH + k]


@njit
def tooth_depth(jaw, i, contact, body_to_head, axes, slope):
    """How deep (m) tooth ``i`` is pressed, and its derivative by the pose (5).

    ``contact`` is the reference point, ``axes`` are those about which the angles turn the body, ``slope`` is the
    fossa's.
    """
    tooth = row3(jaw.teeth, i)
    up = apply_transposed(body_to_head, (0.0, 0.0, 1.0))
    depth = contact[2] + apply(body_to_head, tooth)[2] - tooth[2]
    a, b, c = dot(up, cross(axes[0], tooth)), dot(up, cross(axes[1], tooth)), dot(up, cross(axes[2], tooth))
    return depth, (slope, 0.0, a, b, c)


@njit
def mean_push(jaw, q, scratch):
    """Wrench at the mouthpiece (body axes) by which teeth and condyles' stops push more than they would at ``q``.

    At a stage of the step, with the motion's derivative by what it was at the start in ``scratch.stage``.
    """
    stage, row = scratch.stage, scratch.depth_row
    states = scratch.start_cov.shape[0]
    noise = stage.shape[1] - 2 * N_WRENCH
    contact, body_to_head, axes = contact_point(jaw, q), rotation(q), turning_axes(q)
    mouthpiece, width = vector3(jaw.mouthpiece), jaw.stop_width
    _, slope, _, _ = fossa(jaw, q[0])
    up = apply_transposed(body_to_head, (0.0, 0.0, 1.0))
    force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(N_TEETH):
        depth, by_pose = tooth_depth(jaw, i, contact, body_to_head, axes, slope)
        if depth < -REACH or depth > width + REACH:
            continue
        _, _, a, b, c = by_pose
        for j in range(row.shape[0]):
            k = j if j < states else noise + j - states
            row[j] = slope * stage[0, k] + a * stage[2, k] + b * stage[3, k] + c * stage[4, k]
        push = scale(-jaw.tooth_stiffness * mean_excess(depth, width, scratch), up)
        force = add(force, push)
        moment = add(moment, cross(subtract(row3(jaw.teeth, i), mouthpiece), push))
    back, front = -q[0], q[0] - jaw.crest
    if back > -REACH or front > -REACH:
        for j in range(row.shape[0]):
            row[j] = stage[0, j if j < states else noise + j - states]
        forward = apply_transposed(body_to_head, (1.0, 0.0, 0.0))
        more = mean_excess(back, width, scratch) - mean_excess(front, width, scratch)
        push = scale(jaw.condyle_stiffness * more, forward)
        force = add(force, push)
        moment = subtract(moment, cross(mouthpiece, push))
    return force, moment


@njit
def mean_excess(depth, width, scratch):
    """By how much the mean of ``smooth_ramp`` is above the ramp at ``depth``; ``depth_row`` is the depth's derivative.

    The ramp's curvature is 1/width where 0 < depth < width: so often as the depth lies there. Zero where the depth is
    known to no better than ``LARGEST_SD``.
    """
    row, states = scratch.depth_row, scratch.start_cov.shape[0]
    variance, spread = 0.0, 0.0
    for i in range(states):
        for j in range(states):
            product = row[i] * row[j]
            variance += product * scratch.start_cov[i, j]
            spread += product * scratch.start_spread[i, j]
    for k in range(2 * N_WRENCH):
        square = row[states + k] * row[states + k]
        variance += square * scratch.wrench_cov[k]
        spread += square * scratch.wrench_spread[k]
    if not 0.0 < variance < (LARGEST_SD * width) ** 2:
        return 0.0
    sd = sqrt(2.0 * variance)
    return 0.25 * spread / width * (erf(depth / sd) - erf((depth - width) / sd))


@njit
def push_more(sample, push):
    """A wrench and another, given as force and moment, together."""
    force, moment = push
    return (
        sample[0] + force[0],
        sample[1] + force[1],
        sample[2] + force[2],
        sample[3] + moment[0],
        sample[4] + moment[1],
        sample[5] + moment[2],
    )
