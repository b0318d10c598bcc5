"""The unmodelled wrench where it has memory: an Ornstein-Uhlenbeck process, six states of the filter.

They stand behind the motion's, x = (motion, d). The wrench d is constant over a tick, and acts as the load cell's
reading does; then d <- a d + noise, with a = exp(-dt / time) and a variance s^2 (1 - a^2), so that its sd is s at all
times. Without memory there are no such states, and the wrench is process noise, anew in every tick.
"""

from __future__ import annotations

from jawenv.filter.belief.state import Belief, FilterSettings
from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH


@njit
def add_disturbance(belief: Belief, size, samples, driven):
    """``driven`` (3, 6) = the load cell's ``samples`` and the disturbance as it is believed, behind ``size`` states."""
    for i in range(samples.shape[0]):
        for k in range(N_WRENCH):
            driven[i, k] = samples[i, k]
        for k in range(belief.motion.shape[0] - size):
            driven[i, k] += belief.motion[size + k]


@njit
def set_total(motion_total, wrench, decay, first, total):
    """``total``, the derivative of motion and disturbance by all states and inputs, from that of the motion (n rows).

    Column ``wrench`` of ``motion_total`` is the first of a wrench constant over the tick, by which the disturbance acts
    too; what stands behind the motion's states there goes to the columns from ``first`` on.
    """
    size = motion_total.shape[0]
    total[:, :] = 0.0
    for i in range(size):
        for j in range(size):
            total[i, j] = motion_total[i, j]
        for k in range(total.shape[0] - size):
            total[i, size + k] = motion_total[i, wrench + k]
        for j in range(motion_total.shape[1] - size):
            total[i, first + j] = motion_total[i, size + j]
    for i in range(size, total.shape[0]):
        total[i, i] = decay


@njit
def decay_disturbance(belief: Belief, settings: FilterSettings):
    """The disturbance after the tick, and what is new in it."""
    n_disturbance = settings.disturbance_variance.shape[0]
    first = belief.motion.shape[0] - n_disturbance
    for k in range(n_disturbance):
        belief.motion[first + k] *= settings.disturbance_decay
        belief.motion_cov[first + k, first + k] += settings.disturbance_variance[k]
