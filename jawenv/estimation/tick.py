"""The online filter's work in one tick of the sensors, and what it is told of them."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from jawenv.compiled import njit, njit_within
from jawenv.estimation.ekf import follow_trend
from jawenv.estimation.measurement import N_MEASUREMENTS
from jawenv.estimation.mixture import sum_up
from jawenv.estimation.readings import mark_usable, repair_samples
from jawenv.estimation.sensitivity import N_NOISE, N_SAMPLES
from jawenv.estimation.tension_basis import basis_dtype
from jawenv.estimation.tension_belief import conclude, forget_settling
from jawenv.estimation.tension_filter import predict_motion, update_motion
from jawenv.mechanics.dynamics import N_WRENCH

# Ticks at the start after each of which the belief is renewed: its first guess is far off.
EAGER_TICKS = 20


@cache
def filter_settings_dtype(n_muscles: int, n_states: int, n_nodes: int) -> np.dtype[np.void]:
    """Dtype of what a filter knows of device, patient and prior."""
    fields = [
        ("dt", "f8"),
        ("trajectory", "u1"),
        ("used", "u1", N_MEASUREMENTS),
        ("pose_open", "u1"),
        ("measurement_variance", "f8", N_MEASUREMENTS),
        ("noise_variance", "f8", N_NOISE),
        ("gain_variance", "f8"),
        ("start_sd", "f8", n_states),  # of the motion before the first reading
        ("basis", basis_dtype(n_muscles, n_nodes)),
        ("prior_mean", "f8", (2 * n_muscles,)),
        ("prior_sd", "f8", (2 * n_muscles,)),
    ]
    return np.dtype(fields, align=True)


@cache
def tick_dtype(n_states: int) -> np.dtype[np.void]:
    """Dtype of what is kept of one tick: readings at its end, load cell and true wrench during it, true motion.

    The filter, which may go back to it, reads ``measured``, ``samples`` and ``believed`` alone.
    """
    fields = [
        ("measured", "f8", N_MEASUREMENTS),
        ("samples", "f8", (N_SAMPLES, N_WRENCH)),
        ("wrench", "f8", (N_SAMPLES, N_WRENCH)),
        ("state", "f8", (n_states,)),
        ("believed", "f8", (n_states,)),  # motion before the first measurement; of row 0 alone
    ]
    return np.dtype(fields, align=True)


def leaves_pose_open(used: NDArray[np.bool_], start_sd: NDArray[np.float64], read_share: float = 1.0) -> bool:
    """Whether a tick has fewer numbers of the pose, on average, than the jaw has coordinates that can move.

    Args:
        used: (12,) which readings there are.
        start_sd: (n,) of the motion before the first reading; 0 for what is held.
        read_share: of the ticks, at whose end any encoder is read.
    """
    half = len(start_sd) // 2
    return read_share * float(np.sum(used[: N_MEASUREMENTS // 2])) < float(np.sum(start_sd[:half] > 0.0))


@njit
def begin_motion(belief, motion, sd):
    """The motion (n) believed before the first reading, and its sds (n)."""
    belief.motion_cov[:, :] = 0.0
    for i in range(sd.shape[0]):
        belief.motion[i] = motion[i]
        belief.motion_cov[i, i] = sd[i] * sd[i]


@njit
def take_readings(jaw, device, belief, measured, samples, tick, settings, scratch):
    """Predict over the tick with the load cell's ``samples`` (3, 6), then update with ``measured`` (12) at its end.

    Tick 0 is the start, at which the encoders alone are read. Returns how many readings were left out.
    """
    lost = 0
    if tick > 0:
        scratch.known[:] = settings.noise_variance
        lost += repair_samples(
            samples,
            belief.last_sample,
            belief.held_sample,
            belief.lost_for,
            settings.dt,
            scratch.known,
            scratch.usable,
        )
        predict_motion(
            jaw,
            belief,
            scratch.usable,
            settings.dt,
            scratch.known,
            settings.noise_variance,
            device,
            settings.trajectory,
            scratch,
        )
        follow_trend(belief.trend, scratch.usable, settings.dt)
    lost += mark_usable(measured, belief.last_measured, settings.used, scratch.used)
    if scratch.used.any():
        belief.read += 1
    update_motion(jaw, belief, measured, settings.measurement_variance, scratch.used, scratch)
    forget_settling(jaw, belief, tick)
    return lost


@njit_within
def learn(belief, settings, scratch):
    """The belief about the parameters from all information so far."""
    conclude(belief, settings.prior_mean, settings.prior_sd, settings.gain_variance, scratch)
    sum_up(belief)
