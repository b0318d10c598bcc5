"""How an episode begins: the relaxed jaw at rest, the patient's comfort limits, the prior belief."""

from __future__ import annotations

import numpy as np

from jawenv.device.comfort import FULL_RANGE, HEALTHY_FORE_AFT, HEALTHY_SIDE
from jawenv.device.device import N_MOTORS
from jawenv.device.motors import IDLE, ON_PATH, motor_point, mouthpiece_motion
from jawenv.envs.information import decompose_parameters, refresh_information
from jawenv.envs.kept_ticks import keep_tick
from jawenv.envs.plants import lift_of, take_body, true_state
from jawenv.envs.step_kernel import clear_step, sense
from jawenv.filter.encoders import measure
from jawenv.filter.joint_recursion import update_covariance
from jawenv.filter.joint_step import set_muscles
from jawenv.filter.tick import begin_filter, filter_tick
from jawenv.kernels.compiled import njit, njit_within, world_kernel
from jawenv.kernels.noise import fill_normals
from jawenv.kernels.records import record_dtype
from jawenv.mechanics.bilateral import put_on_fossa, settle_bilateral
from jawenv.mechanics.dynamics import N_STATES
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.kinematics import contact_point, rotation, split
from jawenv.reality.faults import fail
from jawenv.reality.state import reset_reality

# The patient's painless range (grade G): what a slow vertical pull of 12 N opens, at most 25 mm above rest, and no more
# than 45 mm in all.
PAINLESS_FORCE = 12.0
PAINLESS_RANGE = 0.025
LARGEST_OPENING = 0.045
SMALLEST_RANGE = 0.005
RANGE_STEPS = 10
# A jaw that rests outside this box is not one that the device can treat.
REST_OPENING_MAX = 0.035
REST_SIDE_MAX = 0.005
TENSION_MARGIN = 1.5  # soft limit of a muscle's tension over its tension at the end of the painless range
CONDYLE_BACK = -0.5e-3
CONDYLE_FREE = 2.0e-3
CREST_SHARE = 0.92  # of the way to the crest: the soft limit of the condyle's travel

BEGINNING_SCRATCH = record_dtype(
    [
        ("matrix", "f8", (5, 5)),
        ("right", "f8", 5),
        ("poses", "f8", (RANGE_STEPS + 1, 5)),
        ("places", "f8", (RANGE_STEPS + 1, 3)),
        ("body_matrix", "f8", (6, 6)),
        ("body_right", "f8", 6),
    ],
)


@njit
def write_position(jaw, pose, positions, i):
    """Write where the mouthpiece is at ``pose`` (5) into row i of ``places``."""
    q = (pose[0], pose[1], pose[2], pose[3], pose[4])
    place, _ = mouthpiece_motion(jaw, q, (0.0, 0.0, 0.0, 0.0, 0.0), ON_PATH, rotation(q))
    for k in range(3):
        positions[i, k] = place[k]


@njit
def open_slowly(jaw, muscles, pose, sensitivity, scratch):
    """Poses from rest to the end of the painless range, in ``scratch``; returns the last one's number, -1 if none."""
    poses, positions = scratch.poses, scratch.places
    _, converged = settle(jaw, muscles, pose, 0.0, False, sensitivity, scratch.matrix, scratch.right)
    poses[0, :] = pose[:5]
    write_position(jaw, pose, positions, 0)
    rest_opening = jaw.mouthpiece[2] - positions[0, 2]
    if not converged or rest_opening > REST_OPENING_MAX or abs(positions[0, 1]) > REST_SIDE_MAX:
        return -1
    furthest = min(PAINLESS_RANGE, LARGEST_OPENING - rest_opening)
    for i in range(1, RANGE_STEPS + 1):
        poses[i, :] = poses[i - 1, :]
        opening = rest_opening + furthest * i / RANGE_STEPS
        force, converged = settle(jaw, muscles, poses[i], opening, True, sensitivity, scratch.matrix, scratch.right)
        too_far = poses[i, 0] > CREST_SHARE * jaw.crest - CONDYLE_FREE
        if not converged or force > PAINLESS_FORCE or too_far:
            return i - 1
        write_position(jaw, poses[i], positions, i)
    return RANGE_STEPS


@njit
def set_limits(world, last, scratch):
    """Comfort limits of ``world`` from its path of ``last`` + 1 poses; False when the painless range is too small."""
    jaw, limits, poses, positions = world.jaw, world.limits, scratch.poses, scratch.places
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
    limits.side = HEALTHY_SIDE * share
    limits.fore_aft = HEALTHY_FORE_AFT * share
    high = min(max(poses[0, 0], poses[last, 0]) + CONDYLE_FREE, CREST_SHARE * jaw.crest)
    limits.condyle_middle = 0.5 * (CONDYLE_BACK + high)
    limits.condyle_half = 0.5 * (high - CONDYLE_BACK)
    q = (poses[last, 0], poses[last, 1], poses[last, 2], poses[last, 3], poses[last, 4])
    for i in range(world.muscles.shape[0]):
        _, _, _, tension = muscle_pull(jaw, world.muscles, i, contact_point(jaw, q), rotation(q))
        limits.tension[i] = TENSION_MARGIN * tension
    return True


@njit
def rest_on_two_condyles(world, scratch):
    """Move the jaw from the midline model's rest to that on two condyles; False when it does not rest in reach.

    The limits keep their widths, and are counted from the new pose of rest.
    """
    jaw, limits = world.jaw, world.limits
    put_on_fossa(jaw, world.state, world.body)
    no_wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not settle_bilateral(jaw, world.muscles, no_wrench, world.body, scratch.body_matrix, scratch.body_right):
        return False
    take_body(world)
    q, u = split(world.state)
    place, _ = mouthpiece_motion(jaw, q, u, lift_of(world), rotation(q))
    limits.rest_opening = jaw.mouthpiece[2] - place[2]
    limits.rest_side = place[1]
    limits.rest_condyle_side = q[1]
    limits.path[0] = place[0]
    return limits.rest_opening <= REST_OPENING_MAX and abs(limits.rest_side) <= REST_SIDE_MAX


@njit
def reset_motors(device, world):
    """Motors without thrust, their targets where the resting jaw has put them."""
    q, u = split(world.state)
    body_to_head = rotation(q)
    place, velocity = mouthpiece_motion(world.jaw, q, u, lift_of(world), body_to_head)
    motors = world.motors
    for i in range(N_MOTORS):
        _, _, position, _ = motor_point(device, world.jaw, i, body_to_head, place, velocity, (u[2], u[3], u[4]))
        motors.target[i] = position
        motors.thrust[i], motors.command[i], motors.rate[i] = 0.0, 0.0, 0.0
        motors.heat[i], motors.cap[i] = 0.0, device.thrust_peak


@njit
def prior_covariance(world, settings, covariance):
    """The joint prior over motion, log-parameters and gain, for the bound's recursion."""
    first = world.belief.motion.shape[0]
    covariance[:, :] = 0.0
    for i in range(first):
        covariance[i, i] = world.belief.motion_cov[i, i]
    for i in range(settings.filter.prior_sd.shape[0]):
        covariance[first + i, first + i] = settings.filter.prior_sd[i] * settings.filter.prior_sd[i]
    covariance[covariance.shape[0] - 1, covariance.shape[0] - 1] = settings.filter.gain_variance


@njit_within
def reset_belief(device, model, world, settings, scratch, ticks):
    """Prior belief over motion, parameters and load-cell gain, then the first measurement."""
    normals = scratch.normals
    fill_normals((world.key[0], world.key[1]), -1, normals)
    size = world.belief.motion.shape[0]
    for i in range(size):
        ticks[0].believed[i] = true_state(model, world, i) + settings.filter.start_sd[i] * normals[i]
    belief, filter_settings = world.belief, settings.filter
    begin_filter(belief, ticks[0].believed, filter_settings)
    world.cell_gain = device.cell_gain * normals[size]
    world.bound[:, :] = np.nan
    if settings.bound:
        prior_covariance(world, settings, world.bound)
    world.log_det_prior = decompose_parameters(world.belief.cov, 0, scratch.matrix)
    world.log_det_bound = np.nan
    refresh_information(world, settings, scratch.matrix, scratch.right)
    world.log_score_prior = world.log_score
    fill_normals((world.key[0], world.key[1]), -2, normals)
    sense(device, world, scratch, settings)
    fail(
        settings.reality,
        world.reality,
        (world.key[0], world.key[1]),
        -2,
        scratch.measured,
        scratch.samples,
        scratch.faults,
    )
    keep_tick(model, world, settings, scratch, ticks)
    filter_tick(model, belief, ticks, world.tick, scratch.measured, scratch.samples, filter_settings, scratch.filter)
    if settings.bound:
        for i in range(size):
            scratch.joint.state[i] = true_state(model, world, i)
        update_covariance(
            model,
            scratch.joint.state,
            world.bound,
            filter_settings.measurement_variance,
            filter_settings.used,
            scratch.joint,
        )
    refresh_information(world, settings, scratch.matrix, scratch.right)


@njit
def begin_reality(world, settings, scratch):
    """Tissue, load-cell bias and play of the encoders as the episode begins, at rest."""
    q, _ = split(world.state)
    lift = lift_of(world)
    measure(world.jaw, world.state, scratch.joint.rows, scratch.measured)
    scratch.measured[2] += lift[0]
    fill_normals((world.key[0], world.key[1]), -3, scratch.normals)
    reality, muscles = settings.reality, world.muscles
    reset_reality(reality, world.reality, world.jaw, muscles, q, lift, scratch.measured, scratch.normals)


@njit_within
def begin_world(device, model, world, settings, scratch, beginning, ticks):
    """Put one world at rest; False when the device cannot treat its patient."""
    set_muscles(world.jaw, world.log_parameters, 0, world.muscles)
    for k in range(N_STATES):
        world.state[k] = 0.0
    world.state[0] = 3e-3 if world.jaw.free_x else 0.0
    world.state[2] = 0.05
    last = open_slowly(world.jaw, world.muscles, world.state, scratch.joint, beginning)
    world.lift[0], world.lift[1] = 0.0, 0.0
    if last < 0 or not set_limits(world, last, beginning):
        return False
    if world.jaw.condyles == 2 and not rest_on_two_condyles(world, beginning):
        return False
    world.tick = 0
    world.violated = 0
    world.acted = IDLE
    clear_step(world)
    for k in range(6):
        world.reading[k] = 0.0
    reset_motors(device, world)
    world.tracker.target[:] = 0.0
    world.tracker.rate[:] = 0.0
    world.tracker.size[:] = 1.0
    world.tracker.begun = 0
    begin_reality(world, settings, scratch)
    reset_belief(device, model, world, settings, scratch, ticks)
    return True


@world_kernel(place=2)
def begin(devices, models, worlds, chosen, all_settings, scratches, beginnings, accepted, all_ticks, part):
    """Put every chosen world at rest with its ``jaw``, ``log_parameters`` and ``key`` as they stand.

    ``accepted`` (N,) becomes False for a chosen world whose jaw has no rest pose in the treatable box or too small a
    painless range; such a world must be given another patient.
    """
    first, last, thread = part
    for i in range(first, last):
        if chosen[i]:
            accepted[i] = begin_world(
                devices[0],
                models[i],
                worlds[i],
                all_settings[0],
                scratches[thread],
                beginnings[thread],
                all_ticks[i],
            )
