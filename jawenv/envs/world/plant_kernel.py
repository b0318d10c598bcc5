"""Worlds whose true jaw is moved from Python; device, sensors and filter stay compiled.

Such jaws move one after another, so each tick is taken in three parts: the motors' command (compiled), the motion (in
Python, asking the compiled device for its wrench at every step), and load cell, filter and comfort (compiled). A motion
is that of a free mandible, (q, u) as ``jawenv.mechanics.bilateral`` has it, two tuples of six.
"""

from __future__ import annotations

from jawenv.device.device import TICK
from jawenv.device.motors import device_wrench
from jawenv.envs.world.condyles import count_from_rest
from jawenv.envs.world.plants import add_moments, clear_moments, end_motion, lift_of, plus_wrench, take_free_body
from jawenv.envs.world.record import Truth
from jawenv.envs.world.reset_kernel import begin_device, begin_reality, reset_belief
from jawenv.envs.world.step_kernel import (
    StepRows,
    begin_first_tick,
    begin_tick,
    clear_step,
    end_step,
    end_tick,
    take_motion,
)
from jawenv.kernels.compiled import njit, where
from jawenv.kernels.runge_kutta import set_state
from jawenv.mechanics.kinematics import split
from jawenv.reality.joint import tissue_push


def _without_body(truth: Truth, motion):
    return False


@where(lambda truth: truth.typeof("body").shape[0], otherwise=_without_body)
def _keep_body(truth: Truth, motion):
    """The twelve numbers as they are, where the filter's model has two condyles and so believes in all of them."""
    set_state(truth.body, motion[0], motion[1])
    return True


@njit
def _take_moved(truth: Truth, motion):
    """Set what ``truth`` has of the motion of a jaw that Python has moved."""
    _keep_body(truth, motion)
    take_free_body(truth, motion[0], motion[1])


@njit
def plant_rest(devices, models, worlds, i, all_settings, scratches, motion):
    """Let the episode of world i begin where its jaw rests, ``motion``; False if it cannot be treated there.

    It has begun at the midline model's rest, whose random numbers are drawn again.
    """
    device, world, settings = devices[0], worlds[i], all_settings[0]
    _take_moved(world.truth, motion)
    treatable = count_from_rest(world.truth, world.known.limits)
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
    _take_moved(truth, motion)
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
        _take_moved(world.truth, motion)
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
