"""The device follows targets: from an observation and what is wanted to the motors' action.

The law sees what an agent sees and no more. Maneuvers in force and trajectory control use it from outside, through
``follow``; with ``control="targets"`` the device itself does, every ``device.LAW_TICKS`` ticks.
"""

from __future__ import annotations

from math import cos, pi, sin

from jawenv.anatomy import default_fossa
from jawenv.device.channels import (
    FASTEST_TARGET,
    FORE_AFT,
    HIGHEST,
    LOWEST,
    N_CHANNELS,
    OPENING,
    ROLL,
    ROLL_FULL_SCALE_RAD,
    SIDE,
)
from jawenv.device.comfort_settings import Comfort
from jawenv.device.device import N_MOTORS, DeviceRecord
from jawenv.device.guard import CREST_SHARE, Tracker, keep_budget, shrink
from jawenv.device.laws import Felt, Wanted, servo_rates, thrusts, within
from jawenv.envs.observation import FORCE_SCALE, OBSERVATION_REST, POSE_SCALE, RANGE_SCALE
from jawenv.kernels.compiled import njit

# What the law takes where it is not told.
_CREST_M, _FORCE_N = pi / default_fossa().spatial_frequency, Comfort().force_N
_POSE, _JAW = OBSERVATION_REST["pose"].start, OBSERVATION_REST["jaw"].start
_THRUST = OBSERVATION_REST["motor_thrust"].start
_RANGE, _FORCE = OBSERVATION_REST["jaw_range"].start, OBSERVATION_REST["force"].start
_MARGIN, _END = OBSERVATION_REST["comfort_margin"].start, OBSERVATION_REST["comfort_margin"].stop


@njit
def _felt_by(sensed, rest_roll):
    """``Felt`` from an observation's part after the belief; the load cell turns with the mouthpiece."""
    pitch = sensed[_POSE + 2] * POSE_SCALE[2]
    ahead, up = sensed[_FORCE] * FORCE_SCALE, sensed[_FORCE + 2] * FORCE_SCALE
    opened = float(sensed[_JAW])
    return Felt(
        opened * sensed[_RANGE] * RANGE_SCALE[0] * 1e3,
        sensed[_JAW + 1] * sensed[_RANGE + 1] * RANGE_SCALE[1] * 1e3,
        sensed[_POSE + 4] * POSE_SCALE[4] - rest_roll,
        pitch,
        cos(pitch) * ahead + sin(pitch) * up,
        sin(pitch) * ahead - cos(pitch) * up,
        opened,
    )


@njit
def size_of(tracker: Tracker, channel):
    """The factor of a channel's target, as the guard leaves it."""
    return tracker.size[channel] * tracker.budget.size[channel]


@njit
def wanted_by(sensed, tracker: Tracker):
    """``Wanted`` from the targets of ``tracker``, each times its size."""
    opening, side = sensed[_RANGE] * RANGE_SCALE[0] * 1e3, sensed[_RANGE + 1] * RANGE_SCALE[1] * 1e3
    target, rate = tracker.target, tracker.rate
    return Wanted(
        size_of(tracker, OPENING) * target[OPENING] * opening,
        size_of(tracker, SIDE) * target[SIDE] * side,
        size_of(tracker, ROLL) * target[ROLL] * ROLL_FULL_SCALE_RAD,
        size_of(tracker, FORE_AFT) * target[FORE_AFT] * tracker.full_force,
        size_of(tracker, OPENING) * rate[OPENING] * opening,
        size_of(tracker, SIDE) * rate[SIDE] * side,
        size_of(tracker, ROLL) * rate[ROLL] * ROLL_FULL_SCALE_RAD,
    )


@njit
def _let_go(device: DeviceRecord, sensed, release, action):
    """Take thrust from the motors of channels that a budget releases: the upright, then the level pair."""
    rates = max(release[OPENING], release[ROLL]), max(release[SIDE], release[FORE_AFT])
    for motor in range(N_MOTORS):
        lead = sensed[_THRUST + motor] * device.full_scale / device.servo_stiffness
        action[motor] = within(action[motor] - rates[motor // 2] * lead / device.max_rate, 1.0)


@njit
def follow(device: DeviceRecord, observation, parameters, tracker: Tracker, with_servo, holds_roll, dt, action):
    """One decision of the law.

    Args:
        device: record of dtype ``DEVICE``.
        observation: (size,) of one world.
        parameters: how many the observation's belief has.
        tracker: record of dtype ``TRACKER``: its target and rate are followed, the rest is remembered.
        with_servo: rates for trajectory control, else thrusts for force control.
        holds_roll: whether thrusts hold the roll; equal thrusts of the vertical motors leave it free.
        dt: s until the next decision.
        action: (4,) filled.
    """
    sensed = observation[2 * parameters :]
    if not tracker.begun:
        tracker.size[:] = 1.0
        tracker.budget.size[:] = 1.0
        tracker.integral[:] = 0.0
        tracker.rest_roll = sensed[_POSE + 4] * POSE_SCALE[4]
        tracker.begun = True
        if tracker.crest == 0.0:
            tracker.crest, tracker.full_force = _CREST_M, _FORCE_N
    shrink(tracker.size, sensed[_MARGIN:_END], 1.0 - sensed[_POSE] * POSE_SCALE[0] / tracker.crest / CREST_SHARE, dt)
    if tracker.budget.total > 0.0:
        keep_budget(tracker.budget, sensed[_MARGIN:_END], dt)
    targets, felt = wanted_by(sensed, tracker), _felt_by(sensed, tracker.rest_roll)
    if with_servo:
        servo_rates(device, targets, felt, action)
        if tracker.budget.total > 0.0:
            _let_go(device, sensed, tracker.budget.release, action)
    else:
        thrusts(device, targets, felt, holds_roll, tracker.integral, dt, action)


@njit
def follow_all(devices, observations, parameters, trackers, with_servo, holds_roll, dt, actions):
    """``follow`` for N worlds; ``devices`` has one record."""
    for i in range(observations.shape[0]):
        follow(devices[0], observations[i], parameters, trackers[i], with_servo, holds_roll, dt, actions[i])


@njit
def aim(tracker: Tracker, action, period):
    """Set the rates with which the targets reach ``action`` (4, in [-1, 1]) after ``period`` s, or as far as they may.

    An action of -1 to 1 is the whole of a channel: 0 to 1 for the opening, -1 to 1 for the others.
    """
    for k in range(N_CHANNELS):
        goal = LOWEST[k] + 0.5 * (HIGHEST - LOWEST[k]) * (action[k] + 1.0)
        rate = (goal - tracker.target[k]) / period
        tracker.rate[k] = min(max(rate, -FASTEST_TARGET[k]), FASTEST_TARGET[k])


@njit
def move_targets(tracker: Tracker, dt):
    """The targets ``dt`` s later."""
    for k in range(N_CHANNELS):
        tracker.target[k] += tracker.rate[k] * dt
