"""The agent's observation: belief, filtered motion, forces, motors, comfort margins and time, scaled to about one.

Nothing here is given the truth: the estimate of the motion, the load cell, the motors and the clinician's limits are
all that a device would have (``record.known_dtype``).
"""

from __future__ import annotations

from functools import cache
from math import log10, sqrt

from jawenv.base.errors import InputError
from jawenv.device.comfort import N_LIMITS, excursions, set_tension_limits, used_fractions
from jawenv.device.device import N_MOTORS, DeviceRecord
from jawenv.device.motors import ON_PATH, motor_point, mouthpiece_motion
from jawenv.envs.world.record import Control, Known, Seeing
from jawenv.filter.belief.state import FilterSettings
from jawenv.filter.model.joint_step import set_muscles
from jawenv.kernels.compiled import njit
from jawenv.ladder import MODELS
from jawenv.mechanics.bilateral import midline_motion, split_body
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import rotation, split

OBSERVATION_BOUND = 10.0
_BELIEF = ("belief_mean", "belief_sd")  # (mean - prior mean) / prior sd; log10(sd / prior sd); each per parameter
_REST_SIZES = {
    "pose": 5,  # filtered x, y / 5 mm; theta / 0.25 rad; psi, alpha / 0.1 rad
    "rates": 5,  # filtered x', y' / 20 mm/s; omega / 0.5 rad/s
    "jaw": 3,  # opening, side, fore-aft: signed used fractions of the soft limits, 0 at rest
    "jaw_range": 3,  # soft limits: opening / 30 mm, side / 10 mm, fore-aft / 10 mm
    "force": 6,  # load cell, body axes: force / 24 N, moment / (24 N x 20 mm)
    "motor_thrust": N_MOTORS,  # / full scale
    # Trajectory control: each motor's target less its position / 10 mm. Targets control: the channels' targets now, as
    # the guard leaves them. Force control: 0.
    "motor_target": N_MOTORS,
    "comfort_margin": N_LIMITS,  # 1 - used fraction, of the estimate
    "time_left": 1,  # share of the episode
}
POSE_SCALE = (0.005, 0.005, 0.25, 0.1, 0.1)
RATE_SCALE = (0.02, 0.02, 0.5, 0.5, 0.5)
RANGE_SCALE = (0.03, 0.01, 0.01)
FORCE_SCALE = 24.0
MOMENT_SCALE = FORCE_SCALE * 0.02
TARGET_SCALE = 0.01


def observation_layout(n_parameters: int = 12, asked: bool = False) -> dict[str, slice]:
    """Where each part of the flat observation lies, in a model with so many parameters: name -> slice.

    Where muscles are ``asked`` for, ``asked`` (1 or 0 for each) and ``discomfort`` (of the episode so far, s) end it.
    """
    layout, start = {}, 0
    end = {"asked": n_parameters // 2, "discomfort": 1} if asked else {}
    for name, size in (dict.fromkeys(_BELIEF, n_parameters) | _REST_SIZES | end).items():
        layout[name] = slice(start, start + size)
        start += size
    return layout


def observation_size(n_parameters: int = 12, asked: bool = False) -> int:
    """Length of the flat observation."""
    return sum(part.stop - part.start for part in observation_layout(n_parameters, asked).values())


@cache
def layouts() -> dict[int, tuple[int, bool]]:
    """Parameters, and whether muscles are asked for, by the length of an observation: those of the models."""
    numbers = {len(model.muscles.parameter_names) for model in MODELS.values()}
    return {observation_size(number, asked): (number, asked) for number in numbers for asked in (False, True)}


def parameters_of(size: int) -> int:
    """How many parameters an observation of this length belongs to."""
    if size not in layouts():
        raise InputError(f"an observation has {size} values; allowed: {', '.join(map(str, sorted(layouts())))}")
    return layouts()[size][0]


OBSERVATION_LAYOUT = observation_layout()
"""The layout of ``jawenv/Jaw-v3``, with its 12 parameters."""
OBSERVATION_SIZE = observation_size()

OBSERVATION_REST = observation_layout(0)
"""The layout behind the belief, counted from the belief's end."""
_REST = OBSERVATION_REST
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
def bounded(value):
    """``value`` inside the observation's bounds; not-a-number becomes the lower bound."""
    if not value > -OBSERVATION_BOUND:
        return -OBSERVATION_BOUND
    return min(value, OBSERVATION_BOUND)


@njit
def filtered_motion(model: Jaw, mean):
    """The estimated motion in the midline model's coordinates, and the lift of the condyles' midpoint."""
    if model.condyles == 2:
        body_q, body_u = split_body(mean)
        q, u, lift, lift_rate = midline_motion(model, body_q, body_u)
        return q, u, (lift, lift_rate)
    q, u = split(mean)
    return q, u, ON_PATH


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
        row[i] = bounded((known.belief.mean[i] - prior.prior_mean[i]) / prior.prior_sd[i])
        row[parameters + i] = bounded(log10(sd / prior.prior_sd[i]))
    sensed = row[2 * parameters :]
    q, u, lift = filtered_motion(model, known.belief.motion)
    for i in range(5):
        sensed[_POSE + i] = bounded(q[i] / POSE_SCALE[i])
        sensed[_RATES + i] = bounded(u[i] / RATE_SCALE[i])
    body_to_head = rotation(q)
    point, velocity = mouthpiece_motion(model, q, u, lift, body_to_head)
    limits = known.limits
    excursion = excursions(limits, model, point)
    ranges = (limits.opening, limits.side, limits.fore_aft)
    for i in range(3):
        sensed[_JAW + i] = bounded(excursion[i] / ranges[i])
        sensed[_RANGE + i] = bounded(ranges[i] / RANGE_SCALE[i])
        sensed[_FORCE + i] = bounded(known.reading[i] / FORCE_SCALE)
        sensed[_FORCE + 3 + i] = bounded(known.reading[3 + i] / MOMENT_SCALE)
    for i in range(N_MOTORS):
        sensed[_THRUST + i] = bounded(known.motors.thrust[i] / device.full_scale)
        target = 0.0
        if control.targets:
            target = known.tracker.size[i] * known.tracker.target[i]
        elif control.servo:
            _, _, position, _ = motor_point(device, model, i, body_to_head, point, velocity, (u[2], u[3], u[4]))
            target = (known.motors.target[i] - position) / TARGET_SCALE
        sensed[_TARGET + i] = bounded(target)
    set_muscles(model, known.belief.mean, 0, scratch.muscles)
    force = sqrt(known.reading[0] ** 2 + known.reading[1] ** 2 + known.reading[2] ** 2)
    set_tension_limits(model, scratch.muscles, limits, scratch.tension_limits)
    used_fractions(model, scratch.muscles, limits, scratch.tension_limits, q, u, lift, force, scratch.fractions)
    for i in range(N_LIMITS):
        sensed[_MARGIN + i] = bounded(1.0 - scratch.fractions[i])
    sensed[_TIME] = 1.0 - known.tick / (control.steps * control.ticks_per_step)
