"""The agent's observation: belief, filtered motion, forces, motors, comfort margins and time, scaled to about one.

Nothing here is given the truth: the estimate of the motion, the load cell, the motors and the clinician's limits are
all that a device would have (``record.known_dtype``).
"""

from __future__ import annotations

from math import log10, sqrt

from jawenv.device.comfort import N_LIMITS, excursions, set_tension_limits, used_fractions
from jawenv.device.device import N_MOTORS, DeviceRecord
from jawenv.device.motors import ON_PATH, motor_point, mouthpiece_motion
from jawenv.envs.observation import (
    FORCE_SCALE,
    MOMENT_SCALE,
    OBSERVATION_BOUND,
    POSE_SCALE,
    RANGE_SCALE,
    RATE_SCALE,
    TARGET_SCALE,
)
from jawenv.envs.observation import OBSERVATION_REST as _REST
from jawenv.envs.world.record import Control, Known, Seeing
from jawenv.envs.world.tracking import size_of
from jawenv.filter.belief.state import FilterSettings
from jawenv.filter.model.motion_step import set_muscles
from jawenv.kernels.compiled import njit
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import rotation, split

_POSE = _REST["pose"].start
_RATES = _REST["rates"].start
_JAW = _REST["jaw"].start
_RANGE = _REST["jaw_range"].start
_FORCE = _REST["force"].start
_THRUST = _REST["motor_thrust"].start
_TARGET = _REST["motor_target"].start
_MARGIN = _REST["comfort_margin"].start
_TIME = _REST["time_left"].start


@njit
def _bounded(value):
    """``value`` inside the observation's bounds; not-a-number becomes the lower bound."""
    if not value > -OBSERVATION_BOUND:
        return -OBSERVATION_BOUND
    return min(value, OBSERVATION_BOUND)


@njit
def observe_world(
    device: DeviceRecord, model: Jaw, known: Known, control: Control, prior: FilterSettings, scratch: Seeing, row
):
    """Fill one row of the observation.

    Args:
        device: Record of dtype ``DEVICE``.
        model: The jaw as the filter knows it.
        known: Record of dtype ``known_dtype``.
        control: Record of dtype ``Control``.
        prior: Record with ``prior_mean`` and ``prior_sd``: the filter's settings.
        scratch: Record of dtype ``seeing_dtype``.
        row: (size,) float32, filled.
    """
    parameters = prior.prior_mean.shape[0]
    for i in range(parameters):
        sd = sqrt(max(known.belief.cov[i, i], 1e-300))
        row[i] = _bounded((known.belief.mean[i] - prior.prior_mean[i]) / prior.prior_sd[i])
        row[parameters + i] = _bounded(log10(sd / prior.prior_sd[i]))
    sensed = row[2 * parameters :]
    q, u = split(known.belief.motion)
    for i in range(5):
        sensed[_POSE + i] = _bounded(q[i] / POSE_SCALE[i])
        sensed[_RATES + i] = _bounded(u[i] / RATE_SCALE[i])
    body_to_head = rotation(q)
    point, velocity = mouthpiece_motion(model, q, u, ON_PATH, body_to_head)
    limits = known.limits
    excursion = excursions(limits, model, point)
    ranges = (limits.opening, limits.side, limits.fore_aft)
    for i in range(3):
        sensed[_JAW + i] = _bounded(excursion[i] / ranges[i])
        sensed[_RANGE + i] = _bounded(ranges[i] / RANGE_SCALE[i])
        sensed[_FORCE + i] = _bounded(known.reading[i] / FORCE_SCALE)
        sensed[_FORCE + 3 + i] = _bounded(known.reading[3 + i] / MOMENT_SCALE)
    for i in range(N_MOTORS):
        sensed[_THRUST + i] = _bounded(known.motors.thrust[i] / device.full_scale)
        target = 0.0
        if control.targets:
            target = size_of(known.tracker, i) * known.tracker.target[i]
        elif control.servo:
            _, _, position, _ = motor_point(device, model, i, body_to_head, point, velocity, (u[2], u[3], u[4]))
            target = (known.motors.target[i] - position) / TARGET_SCALE
        sensed[_TARGET + i] = _bounded(target)
    set_muscles(model, known.belief.mean, scratch.muscles)
    force = sqrt(known.reading[0] ** 2 + known.reading[1] ** 2 + known.reading[2] ** 2)
    set_tension_limits(model, scratch.muscles, limits, scratch.tension_limits)
    used_fractions(model, scratch.muscles, limits, scratch.tension_limits, (q, u, ON_PATH), force, scratch.fractions)
    for i in range(N_LIMITS):
        sensed[_MARGIN + i] = _bounded(1.0 - scratch.fractions[i])
    sensed[_TIME] = 1.0 - known.tick / (control.steps * control.ticks_per_step)
