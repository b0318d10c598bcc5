"""Nearness of the teeth, as believed and as read, and what nobody knows of their force."""

from __future__ import annotations

from jawenv.filter.belief.state import Belief
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import apply, row3, vector3
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH
from jawenv.mechanics.forces import smooth_ramp
from jawenv.mechanics.jaw import N_TEETH, Jaw
from jawenv.mechanics.kinematics import contact_point, rotation

# m: nothing is learnt while teeth are nearer. The error of their force lasts as long as they press, and is no noise;
# nor do the encoders show whether they press lightly.
LEAST_GAP = 1e-4
COARSEST = 1e-3  # m, of an encoder's noise that tells it
LOST_SDS = 300.0  # of the motion before the first reading: of the motion that a wrong belief predicts beside the teeth
# Sd of each component of the wrench over the teeth's force; the last three in m.
TOOTH_NOISE = (0.1, 0.1, 0.2, 0.006, 0.008, 0.002)


@njit
def bite_force(jaw: Jaw, motion, nearer=0.0):
    """Force (N) with which the teeth press, or would press if they were ``nearer`` (m)."""
    pose = (motion[0], motion[1], motion[2], motion[3], motion[4])
    return _force_at(jaw, contact_point(jaw, pose)[2] + nearer, rotation(pose))


@njit
def _force_at(jaw: Jaw, height, body_to_head):
    """Force (N) of the teeth with the contact point so high (m)."""
    force = 0.0
    for i in range(N_TEETH):
        arm = apply(body_to_head, row3(jaw.teeth, i))
        ramp, _ = smooth_ramp(height + arm[2] - jaw.teeth[i, 2], jaw.stop_width)
        force += jaw.tooth_stiffness * ramp
    return force


@njit
def reads_pose(used, variances):
    """Whether the encoders in use (12), with noise of ``variances``, tell how near the teeth are."""
    return used[2] and used[3] and used[4] and used[5] and variances[2] < COARSEST * COARSEST


@njit
def read_bite(jaw: Jaw, measured, nearer):
    """``bite_force`` at the pose that the encoders read (12).

    A belief that has one side too stiff or too soft takes a jaw for lifted that rests on the teeth of one side.
    """
    body_to_head = rotation((0.0, 0.0, measured[3], measured[4], measured[5]))
    height = measured[2] + jaw.zero[2]
    return _force_at(jaw, height - apply(body_to_head, vector3(jaw.mouthpiece))[2] + nearer, body_to_head)


@njit
def add_tooth_noise(force, variance):
    """Add to the process noise ``variance`` (6) what the ``force`` (N) of the teeth may be off by.

    Nobody knows what teeth and their ligament do: a fifth of the force upwards, half of that across, and the moments of
    both about the mouthpiece.
    """
    for k in range(N_WRENCH):
        sd = TOOTH_NOISE[k] * force
        variance[k] += sd * sd


@njit
def forget_motion(jaw: Jaw, belief: Belief, before, sd):
    """Widen the motion beyond what the encoders read, which it is then: no model of teeth and muscles is in it.

    It begins from the motion ``before`` the tick, about which the readings are nearly linear: what a wrong belief makes
    of a tick beside the teeth may be far off. What is known of a disturbance with memory stays.
    """
    for i in range(N_STATES):
        belief.motion_cov[i, :] = 0.0
        belief.motion_cov[:, i] = 0.0
        belief.motion_cov[i, i] = LOST_SDS * LOST_SDS * sd[i] * sd[i]
        belief.by_tension[i, :] = 0.0
        belief.motion[i] = before[i]
