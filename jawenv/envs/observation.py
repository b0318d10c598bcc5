"""What the agent sees: belief, filtered motion, forces, motors, comfort margins and time, scaled to about one.

Nothing here reads the truth: the estimate of the motion, the load cell, the motors and the clinician's limits are all
that a device would have.
"""

from __future__ import annotations

from math import log10, sqrt

from numba import prange
from numba.np.ufunc.parallel import get_thread_id

from jawenv.compiled import njit, world_kernel
from jawenv.device.comfort import N_LIMITS, SOFT_FORCE, used_fractions
from jawenv.device.device import N_MOTORS
from jawenv.device.linkage import excursions
from jawenv.device.motors import motor_point, mouthpiece_motion
from jawenv.estimation.ekf import GAIN, set_muscles
from jawenv.mechanics.dynamics import N_STATES
from jawenv.mechanics.jaw import N_PARAMETERS
from jawenv.mechanics.kinematics import rotation, split

OBSERVATION_BOUND = 10.0
_SIZES = {
    "belief_mean": N_PARAMETERS,  # (mean - prior mean) / prior sd
    "belief_sd": N_PARAMETERS,  # log10(sd / prior sd)
    "pose": 5,  # filtered x, y / 5 mm; theta / 0.25 rad; psi, alpha / 0.1 rad
    "rates": 5,  # filtered x', y' / 20 mm/s; omega / 0.5 rad/s
    "jaw": 3,  # opening, side, fore-aft: signed used fractions of the soft limits, 0 at rest
    "jaw_range": 3,  # soft limits: opening / 30 mm, side / 10 mm, fore-aft / 10 mm
    "force": 6,  # load cell, body axes: force / soft limit, moment / (soft limit x 20 mm)
    "motor_thrust": N_MOTORS,  # / full scale
    "motor_target": N_MOTORS,  # target less actual position / 10 mm; 0 in force control
    "comfort_margin": N_LIMITS,  # 1 - used fraction, of the estimate
    "time_left": 1,  # share of the episode
}
POSE_SCALE = (0.005, 0.005, 0.25, 0.1, 0.1)
RATE_SCALE = (0.02, 0.02, 0.5, 0.5, 0.5)
RANGE_SCALE = (0.03, 0.01, 0.01)
MOMENT_SCALE = SOFT_FORCE * 0.02
TARGET_SCALE = 0.01


def _layout() -> dict[str, slice]:
    layout, start = {}, 0
    for name, size in _SIZES.items():
        layout[name] = slice(start, start + size)
        start += size
    return layout


OBSERVATION_LAYOUT = _layout()
"""Where each part of the flat observation lies: name -> slice."""
OBSERVATION_SIZE = sum(_SIZES.values())

_MEAN = OBSERVATION_LAYOUT["belief_mean"].start
_SD = OBSERVATION_LAYOUT["belief_sd"].start
_POSE = OBSERVATION_LAYOUT["pose"].start
_RATES = OBSERVATION_LAYOUT["rates"].start
_JAW = OBSERVATION_LAYOUT["jaw"].start
_RANGE = OBSERVATION_LAYOUT["jaw_range"].start
_FORCE = OBSERVATION_LAYOUT["force"].start
_THRUST = OBSERVATION_LAYOUT["motor_thrust"].start
_TARGET = OBSERVATION_LAYOUT["motor_target"].start
_MARGIN = OBSERVATION_LAYOUT["comfort_margin"].start
_TIME = OBSERVATION_LAYOUT["time_left"].start


@njit
def bounded(value):
    """``value`` inside the observation's bounds; not-a-number becomes the lower bound."""
    if not value > -OBSERVATION_BOUND:
        return -OBSERVATION_BOUND
    return min(value, OBSERVATION_BOUND)


@njit
def observe_world(device, model, world, settings, scratch, seen):
    """Fill one row of the observation."""
    for i in range(N_PARAMETERS):
        sd = sqrt(max(world.covariance[N_STATES + i, N_STATES + i], 1e-300))
        seen[_MEAN + i] = bounded((world.mean[N_STATES + i] - settings.prior_mean[i]) / settings.prior_sd[i])
        seen[_SD + i] = bounded(log10(sd / settings.prior_sd[i]))
    q, u = split(world.mean)
    for i in range(5):
        seen[_POSE + i] = bounded(q[i] / POSE_SCALE[i])
        seen[_RATES + i] = bounded(u[i] / RATE_SCALE[i])
    body_to_head = rotation(q)
    place, velocity = mouthpiece_motion(model, q, u, body_to_head)
    limits = world.limits
    excursion = excursions(limits, model, place)
    ranges = (limits.opening, limits.side, limits.fore_aft)
    for i in range(3):
        seen[_JAW + i] = bounded(excursion[i] / ranges[i])
        seen[_RANGE + i] = bounded(ranges[i] / RANGE_SCALE[i])
        seen[_FORCE + i] = bounded(world.reading[i] / SOFT_FORCE)
        seen[_FORCE + 3 + i] = bounded(world.reading[3 + i] / MOMENT_SCALE)
    for i in range(N_MOTORS):
        seen[_THRUST + i] = bounded(world.motors.thrust[i] / device.full_scale)
        lead = 0.0
        if settings.trajectory:
            _, _, position, _ = motor_point(device, model, i, body_to_head, place, velocity, (u[2], u[3], u[4]))
            lead = world.motors.target[i] - position
        seen[_TARGET + i] = bounded(lead / TARGET_SCALE)
    set_muscles(world.mean, N_STATES, scratch.filter.muscles)
    force = (1.0 + world.mean[GAIN]) * sqrt(world.reading[0] ** 2 + world.reading[1] ** 2 + world.reading[2] ** 2)
    used_fractions(model, scratch.filter.muscles, limits, q, u, force, scratch.fractions)
    for i in range(N_LIMITS):
        seen[_MARGIN + i] = bounded(1.0 - scratch.fractions[i])
    seen[_TIME] = 1.0 - world.tick / (settings.steps * settings.ticks_per_step)


@world_kernel(place=2)
def observe(devices, models, worlds, all_settings, scratches, observation):
    """Fill ``observation`` (N, 63), float32."""
    for i in prange(worlds.shape[0]):
        observe_world(devices[0], models[i], worlds[i], all_settings[0], scratches[get_thread_id()], observation[i])
