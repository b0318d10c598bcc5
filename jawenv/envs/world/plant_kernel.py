"""Worlds whose true jaw is moved from Python; device, sensors and filter stay compiled.

Such jaws move one after another, so each tick is taken in three parts: the motors' command (compiled), the motion (in
Python, asking the compiled device for its wrench at every step), and load cell, filter and comfort (compiled). A motion
is that of a free mandible, (q, u) as ``jawenv.mechanics.kinematics`` has it, two tuples of six.
"""

from __future__ import annotations

from jawenv.device.comfort import Limits
from jawenv.device.device import TICK
from jawenv.device.motors import device_wrench, mouthpiece_motion
from jawenv.envs.world.plants import add_moments, clear_moments, end_motion, lift_of, plus_wrench, take_free_body
from jawenv.envs.world.record import Truth
from jawenv.envs.world.reset_kernel import REST_OPENING_MAX, REST_SIDE_MAX, begin_device, begin_reality, reset_belief
from jawenv.envs.world.step_kernel import (
    StepRows,
    begin_first_tick,
    begin_tick,
    clear_step,
    end_step,
    end_tick,
    take_motion,
)
from jawenv.kernels.compiled import njit
from jawenv.mechanics.kinematics import rotation, split
from jawenv.reality.joint import tissue_push


@njit
def _count_from_rest(truth: Truth, limits: Limits):
    """Count the limits, which keep their widths, from where the jaw rests; whether the device can treat it there."""
    q, u = split(truth.state)
    point, _ = mouthpiece_motion(truth.jaw, q, u, lift_of(truth), rotation(q))
    limits.rest_opening = truth.jaw.mouthpiece[2] - point[2]
    limits.rest_side = point[1]
    limits.rest_condyle_side = q[1]
    limits.path[0] = point[0]
    return limits.rest_opening <= REST_OPENING_MAX and abs(limits.rest_side) <= REST_SIDE_MAX


@njit
def plant_rest(devices, models, worlds, i, all_settings, scratches, motion):
    """Let the episode of world i begin where its jaw rests, ``motion``; False if it cannot be treated there.

    It has begun at the midline model's rest, whose random numbers are drawn again.
    """
    device, world, settings = devices[0], worlds[i], all_settings[0]
    take_free_body(world.truth, motion[0], motion[1])
    treatable = _count_from_rest(world.truth, world.known.limits)
    begin_device(device, models[i], world, settings)
    begin_reality(world.truth, settings.reality, scratches[i])
    reset_belief(device, models[i], world, settings, scratches[i])
    return treatable


@njit
def plant_begin(devices, models, worlds, i, actions, all_settings, scratches):
    """Command of one tick of world i."""
    device, world, settings, scratch = devices[0], worlds[i], all_settings[0], scratches[i]
    begin_tick(device, models[i], world, actions[i], settings, scratch)
    truth, known = world.truth, world.known
    q, u = split(truth.state)
    lift, servo = lift_of(truth), settings.control.servo
    _, acted = device_wrench(device, truth.jaw, known.limits, known.motors, (q, u, lift), 0.0, servo)
    clear_moments(scratch.wrench)
    scratch.acted = acted


@njit
def plant_wrench(devices, worlds, i, all_settings, scratches, motion, times):
    """Wrench (6) of device, disturbance and joint on world i, on the mouthpiece in body axes.

    ``times`` are those since the command (s) for which the device answers and about which the wrench acts, and for how
    long it does.
    """
    since, middle, length = times
    device, truth, known, scratch, settings = (
        devices[0],
        worlds[i].truth,
        worlds[i].known,
        scratches[i],
        all_settings[0],
    )
    take_free_body(truth, motion[0], motion[1])
    q, u = split(truth.state)
    lift, servo = lift_of(truth), settings.control.servo
    wrench, acted = device_wrench(device, truth.jaw, known.limits, known.motors, (q, u, lift), since, servo)
    scratch.acted = max(scratch.acted, acted)
    add_moments(scratch.wrench, wrench, length / TICK, 2.0 * middle / TICK - 1.0)
    push = tissue_push(settings.reality, known.limits, truth.jaw, q, lift)
    return plus_wrench(wrench, truth.unmodelled, push)


@njit
def plant_end(devices, models, worlds, i, all_settings, scratches, rows: StepRows, motion):
    """Sensors, filter and comfort of one tick of world i, whose jaw has come to ``motion``; or its first reading."""
    device, world, settings, scratch = devices[0], worlds[i], all_settings[0], scratches[i]
    if world.known.tick < 0:
        begin_first_tick(world.truth, scratch)
    else:
        take_free_body(world.truth, motion[0], motion[1])
        acted = max(scratch.acted, end_motion(device, world, scratch, settings.control.servo))
        take_motion(device, world, scratch, 1.0 / settings.control.ticks_per_step, acted)
    end_tick(device, models[i], world, settings, scratch, rows.ticks[i], rows.paths[i])


@njit
def plant_clear(worlds, i):
    """Forget the last step's discomfort of world i."""
    clear_step(worlds[i])


@njit
def plant_inform(devices, models, worlds, i, all_settings, scratches, rows: StepRows):
    """Belief of world i, what it is worth, and what is seen, at a step's end."""
    end_step(devices[0], models[i], worlds[i], all_settings[0], scratches[i], rows.observation[i])
