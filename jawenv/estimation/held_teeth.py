"""How steep teeth are, for a filter that does not know how deep they are pressed.

Over their onset teeth stiffen as they are pressed together. Two things are made of that.

They are as steep as they are *on average* over the depths that may be true. Where encoders are slow, these spread over
the whole onset between two readings, and the steepness at the estimate is that of one of them: stochastic
linearisation (Gelb 1974, Applied Optimal Estimation, section 6.2), of which ``contact_mean`` has the force.

And they are as steep as where they have been *of late*. With their steepness taken at the estimate, the filter's
gains and regressors tremble with the estimate's errors, and so do the next innovations wherever estimate and error are
correlated (D in ``noisy_input``): under a servo, which answers to the true motion, and under a noisy load cell. What
both share passes for tension, by up to six sds where a servo holds a jaw on its teeth for half a minute.

So a tooth's steepness is taken at a mean of its depth over the last tenth of a second, in which errors cancel, while
the depth at the estimate differs from that mean by no more than it may be wrong; where the jaw truly moves, it is that
of the estimate. The force is always that at the estimate, and on average (``contact_mean``). Jacobians at something
else than the latest estimate, so that what is learned does not hang on its errors, are those of Huang, Mourikis &
Roumeliotis (2010, Int. J. Robotics Research 29:502).
"""

from __future__ import annotations

from math import erf, exp, pi, sqrt
from typing import Any

from jawenv.compiled import njit
from jawenv.estimation.contact_mean import tooth_depth
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.forces import smooth_ramp
from jawenv.mechanics.jaw import N_TEETH
from jawenv.mechanics.kinematics import contact_point, fossa, rotation, split, turning_axes
from jawenv.mechanics.vec3 import apply_transposed, cross, row3, scale, subtract, vector3

MEAN_OVER = 0.1  # s; three times as long changes nothing
LARGEST_OFFSET = 3.0  # sds of the depth
FAR = 6.0  # sds from the onset's ends, beyond which no depth that may be true lies within it
SHARP = 1e-4  # widths of the onset; a smaller sd is none


def held_teeth_fields() -> list[Any]:
    """Working memory of this file as fields of a dtype; ``steepness`` counts where a tooth is ``held``."""
    return [
        ("held", "u1", (N_TEETH,)),
        ("steepness", "f8", (N_TEETH,)),
        ("depth_variance", "f8", (N_TEETH,)),  # m^2, at the start of the step
    ]


@njit
def mean_steepness(depth, variance, width):
    """The mean slope of ``smooth_ramp`` over normal depths of this mean (m) and variance (m^2)."""
    sd = sqrt(max(variance, 0.0))
    if depth < -FAR * sd:
        return 0.0
    if depth - width > FAR * sd:
        return 1.0
    if sd < SHARP * width:
        return smooth_ramp(depth, width)[1]
    return (mean_positive_part(depth, sd) - mean_positive_part(depth - width, sd)) / width


@njit
def mean_positive_part(mean, sd):
    """The mean of max(0, x) over normal x."""
    z = mean / sd
    return 0.5 * mean * (1.0 + erf(z / sqrt(2.0))) + sd * exp(-0.5 * z * z) / sqrt(2.0 * pi)


@njit
def follow_teeth(jaw, motion, covariance, depths, dt, scratch):
    """Move ``depths`` (teeth; m), the means, on by ``dt`` (s), and set which teeth are held in the coming step.

    ``motion`` (10,) is the estimate, ``covariance`` its covariance; a mean that is not a number begins anew.
    """
    q, _ = split(motion)
    contact, body_to_head, axes = contact_point(jaw, q), rotation(q), turning_axes(q)
    _, slope, _, _ = fossa(jaw, q[0])
    for i in range(N_TEETH):
        depth, by_pose = tooth_depth(jaw, i, contact, body_to_head, axes, slope)
        variance = 0.0
        for j in range(5):
            for k in range(5):
                variance += by_pose[j] * by_pose[k] * covariance[j, k]
        scratch.depth_variance[i] = variance
        offset = depth - depths[i]
        if offset * offset <= LARGEST_OFFSET * LARGEST_OFFSET * variance:
            depths[i] += offset * min(1.0, dt / MEAN_OVER)
            scratch.held[i] = 1
            scratch.steepness[i] = mean_steepness(depths[i], variance, jaw.stop_width)
        else:
            depths[i] = depth
            scratch.held[i] = 0


@njit
def hold_teeth(jaw, q, scratch):
    """Change the derivative ``scratch.slope`` at a stage of the step to that of teeth as steep as they are taken to be.

    A held one by ``scratch.steepness``, another as on average over the depths that may be true there.
    """
    stage, slope_by_all, by_input = scratch.stage, scratch.slope, scratch.by_input
    contact, body_to_head, axes = contact_point(jaw, q), rotation(q), turning_axes(q)
    mouthpiece, first = vector3(jaw.mouthpiece), by_input.shape[1] - N_WRENCH
    _, slope, _, _ = fossa(jaw, q[0])
    up = apply_transposed(body_to_head, (0.0, 0.0, 1.0))
    for i in range(N_TEETH):
        depth, by_pose = tooth_depth(jaw, i, contact, body_to_head, axes, slope)
        _, steepness = smooth_ramp(depth, jaw.stop_width)
        if scratch.held[i]:
            wanted = scratch.steepness[i]
        else:
            wanted = mean_steepness(depth, scratch.depth_variance[i], jaw.stop_width)
        if steepness == wanted:
            continue
        force = scale(jaw.tooth_stiffness * (steepness - wanted), up)
        moment = cross(subtract(row3(jaw.teeth, i), mouthpiece), force)
        for row in range(5):
            factor = 0.0
            for k in range(3):
                factor += by_input[row, first + k] * force[k] + by_input[row, first + 3 + k] * moment[k]
            a, b, c, d = factor * by_pose[0], factor * by_pose[2], factor * by_pose[3], factor * by_pose[4]
            for j in range(stage.shape[1]):
                slope_by_all[5 + row, j] += a * stage[0, j] + b * stage[2, j] + c * stage[3, j] + d * stage[4, j]
