"""Beginning of an episode: the relaxed jaw at rest, the patient's comfort limits, the prior belief."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.device.comfort import ComfortRecord, Limits, set_general_limits, set_tension_limits
from jawenv.device.comfort_settings import SMALLEST_RANGE_MM
from jawenv.device.device import N_MOTORS, DeviceRecord
from jawenv.device.motors import IDLE, ON_PATH, Motors, motor_point, mouthpiece_motion
from jawenv.envs.world.information import refresh_information
from jawenv.envs.world.plants import lift_of
from jawenv.envs.world.record import Scratch, Settings, Truth, World
from jawenv.envs.world.step_kernel import REALITY_TICK, START_TICK, Shared, clear_step
from jawenv.filter.model.encoders import measure
from jawenv.filter.model.motion_step import set_muscles
from jawenv.filter.tick import begin_filter
from jawenv.kernels.compiled import njit, njit_within, world_kernel
from jawenv.kernels.noise import fill_normals
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import Linear, linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import rotation, split
from jawenv.reality.options import RealityRecord
from jawenv.reality.state import reset_reality

# A jaw that rests outside this box is not one that the device can treat.
REST_OPENING_MAX = 0.035
REST_SIDE_MAX = 0.005
FULL_RANGE = 0.048  # m, mean maximal opening of healthy adults (Zawawi 2003)
SMALLEST_RANGE = 1e-3 * SMALLEST_RANGE_MM
RANGE_STEPS = 10
CREST_SHARE = 0.92  # of the way to the crest: the soft limit of the condyle's travel


class _Beginning:
    """One thread's working memory of ``begin``."""

    linear: Linear
    matrix: Annotated[Array, 5, 5]
    right: Annotated[Array, 5]
    poses: Annotated[Array, RANGE_STEPS + 1, 5]
    places: Annotated[Array, RANGE_STEPS + 1, 3]


@cache
def beginning_dtype(n_lines: int) -> np.dtype[np.void]:
    """Dtype of ``_Beginning``."""
    return record_dtype(_Beginning, linear=linear_dtype(n_lines))


@njit
def _write_position(jaw: Jaw, pose, positions, i):
    """Write where the mouthpiece is at ``pose`` (5) into row i of ``places``."""
    q = (pose[0], pose[1], pose[2], pose[3], pose[4])
    point, _ = mouthpiece_motion(jaw, q, (0.0, 0.0, 0.0, 0.0, 0.0), ON_PATH, rotation(q))
    for k in range(3):
        positions[i, k] = point[k]


@njit
def _open_slowly(jaw: Jaw, muscles, comfort: ComfortRecord, pose, scratch: _Beginning):
    """Poses from rest to the end of the painless range, in ``scratch``; returns the last one's number, -1 if none.

    ``pose`` (5 or more) is near the rest, and becomes it.
    """
    poses, positions = scratch.poses, scratch.places
    for i in range(5):
        poses[0, i] = pose[i]
    _, converged = settle(jaw, muscles, poses[0], 0.0, False, scratch.linear, scratch.matrix, scratch.right)
    for i in range(5):
        pose[i] = poses[0, i]
    _write_position(jaw, poses[0], positions, 0)
    rest_opening = jaw.mouthpiece[2] - positions[0, 2]
    if not converged or rest_opening > REST_OPENING_MAX or abs(positions[0, 1]) > REST_SIDE_MAX:
        return -1
    furthest = min(comfort.painless_range, comfort.largest_opening - rest_opening)
    for i in range(1, RANGE_STEPS + 1):
        poses[i, :] = poses[i - 1, :]
        opening = rest_opening + furthest * i / RANGE_STEPS
        force, converged = settle(jaw, muscles, poses[i], opening, True, scratch.linear, scratch.matrix, scratch.right)
        too_far = poses[i, 0] > CREST_SHARE * jaw.crest - comfort.condyle_free
        if not converged or force > comfort.painless_force or too_far:
            return i - 1
        _write_position(jaw, poses[i], positions, i)
    return RANGE_STEPS


@njit
def _set_limits(jaw: Jaw, muscles, comfort: ComfortRecord, limits: Limits, last, scratch: _Beginning):
    """Comfort limits from the jaw's path of ``last`` + 1 poses; False when the painless range is too small."""
    poses, positions = scratch.poses, scratch.places
    set_general_limits(comfort, limits)
    limits.rest_opening = jaw.mouthpiece[2] - positions[0, 2]
    limits.rest_side = positions[0, 1]
    limits.rest_condyle_side = poses[0, 1]
    limits.opening = positions[0, 2] - positions[last, 2]
    if last < 2 or limits.opening < SMALLEST_RANGE:
        return False
    middle = last // 2
    s = (positions[0, 2] - positions[middle, 2]) / limits.opening
    to_middle, to_end = positions[middle, 0] - positions[0, 0], positions[last, 0] - positions[0, 0]
    bend = (to_middle - to_end * s) / (s * s - s)
    limits.path[0], limits.path[1], limits.path[2] = positions[0, 0], to_end - bend, bend
    share = (max(limits.rest_opening, 0.0) + limits.opening) / FULL_RANGE
    limits.side = comfort.side * share
    limits.fore_aft = comfort.fore_aft * share
    high = min(max(poses[0, 0], poses[last, 0]) + comfort.condyle_free, CREST_SHARE * jaw.crest)
    limits.condyle_middle = 0.5 * (high - comfort.condyle_back)
    limits.condyle_half = 0.5 * (high + comfort.condyle_back)
    for k in range(5):
        limits.end[k] = poses[last, k]
    limits.tension_margin = comfort.tension_margin
    set_tension_limits(jaw, muscles, limits, limits.tension)
    return True


@njit
def _reset_motors(device: DeviceRecord, truth: Truth, motors: Motors):
    """Motors without thrust, their targets where the resting jaw has put them."""
    q, u = split(truth.state)
    body_to_head = rotation(q)
    point, velocity = mouthpiece_motion(truth.jaw, q, u, lift_of(truth), body_to_head)
    for i in range(N_MOTORS):
        _, _, position, _ = motor_point(device, truth.jaw, i, body_to_head, point, velocity, (u[2], u[3], u[4]))
        motors.target[i] = position
        motors.thrust[i], motors.command[i], motors.rate[i] = 0.0, 0.0, 0.0
        motors.heat[i], motors.cap[i] = 0.0, device.thrust_peak


@njit
def reset_belief(device: DeviceRecord, model: Jaw, world: World, settings: Settings, scratch: Scratch):
    """Prior belief over motion, parameters and load-cell gain, before the first reading."""
    truth, known, normals = world.truth, world.known, scratch.normals
    fill_normals((truth.key[0], truth.key[1]), START_TICK, normals)
    began, sd = known.belief.began, settings.filter.start_sd
    size = len(began)
    for i in range(size):
        began[i] = truth.state[i] + sd[i] * normals[i]
    begin_filter(model, known.belief, began, settings.filter)
    truth.cell_gain = device.cell_gain * normals[size]
    truth.bound[:, :] = np.nan
    truth.log_det_bound = np.nan
    refresh_information(world, scratch.matrix, scratch.right)
    known.log_det_prior = known.log_det
    truth.log_score_prior = truth.log_score


@njit
def begin_reality(truth: Truth, reality: RealityRecord, scratch: Scratch):
    """Tissue, load-cell bias and play of the encoders as the episode begins, at rest."""
    q, _ = split(truth.state)
    lift = lift_of(truth)
    measure(truth.jaw, truth.state, scratch.rows, scratch.measured)
    scratch.measured[2] += lift[0]
    fill_normals((truth.key[0], truth.key[1]), REALITY_TICK, scratch.normals)
    reset_reality(reality, truth.reality, truth.jaw, truth.muscles, q, lift, scratch.measured, scratch.normals)


@njit
def begin_device(device: DeviceRecord, model: Jaw, world: World, settings: Settings):
    """Clock, motors, targets and load cell as an episode begins, of the jaw at rest; nothing has been read."""
    known = world.known
    known.tick = -1
    clear_step(world)
    known.reading[:] = 0.0
    _reset_motors(device, world.truth, known.motors)
    known.tracker.target[:] = 0.0
    known.tracker.rate[:] = 0.0
    known.tracker.size[:] = 1.0
    known.tracker.begun = False
    known.tracker.crest, known.tracker.full_force = model.crest, known.limits.force
    budget = known.tracker.budget
    budget.total, budget.spent = settings.control.budget, 0.0
    budget.size[:], budget.margin[:] = 1.0, 1.0
    budget.hard[:] = settings.comfort.hard


@njit_within
def _begin_world(device: DeviceRecord, model: Jaw, world: World, settings: Settings, scratch: Scratch, beginning):
    """Put one world at rest; False when the device cannot treat its patient."""
    truth, limits = world.truth, world.known.limits
    set_muscles(truth.jaw, truth.log_parameters, truth.muscles)
    truth.state[:] = 0.0
    truth.state[0] = 3e-3 if truth.jaw.free_x else 0.0
    truth.state[2] = 0.05
    last = _open_slowly(truth.jaw, truth.muscles, settings.comfort, truth.state, beginning)
    truth.lift[0], truth.lift[1] = 0.0, 0.0
    if last < 0 or not _set_limits(truth.jaw, truth.muscles, settings.comfort, limits, last, beginning):
        return False
    truth.violated = False
    truth.acted = IDLE
    begin_device(device, model, world, settings)
    begin_reality(truth, settings.reality, scratch)
    reset_belief(device, model, world, settings, scratch)
    return True


@world_kernel(position=2)
def begin(shared: Shared, models, worlds, chosen, beginnings, accepted, part):
    """Put every chosen world at rest with its ``jaw``, ``log_parameters`` and ``key`` as they stand.

    Its sensors are read for the first time by the next call of ``advance``.
    ``accepted`` (N,) becomes False for a chosen world whose jaw has no rest pose in the treatable box or too small a
    painless range; such a world must be given another patient.
    """
    first, last, thread = part
    for i in range(first, last):
        if chosen[i]:
            accepted[i] = _begin_world(
                shared.devices[0],
                models[i],
                worlds[i],
                shared.settings[0],
                shared.scratches[thread],
                beginnings[thread],
            )
