"""The world's clock: one control period of every world, filter and observation included, in one compiled call.

The first call of an episode is its first reading, of the jaw at rest: a tick without motion. So the filter is compiled
into one kernel only.
"""

from __future__ import annotations

from functools import cache
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.device.comfort import N_LIMITS, cost_of, used_fractions
from jawenv.device.device import LAW_TICKS, TICK, DeviceRecord
from jawenv.device.force_sensor import read_force
from jawenv.device.motors import command_motors
from jawenv.envs.observation import Parts
from jawenv.envs.world.information import refresh_information
from jawenv.envs.world.kept_ticks import keep_reading, keep_truth
from jawenv.envs.world.observation import observe_world
from jawenv.envs.world.plants import lift_of, true_motion
from jawenv.envs.world.record import Known, Scratch, Settings, Truth, World, seeing_dtype
from jawenv.envs.world.tracking import aim, follow, move_targets
from jawenv.filter.learn import conclude
from jawenv.filter.model.encoders import measure
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.filter.nuisances.turned import add_offset, turn_readings, turn_wrench
from jawenv.filter.readings.cell_trend import mean_force, mean_reading
from jawenv.filter.tick import filter_scratch_dtype, filter_tick
from jawenv.kernels.compiled import njit, njit_within, world_kernel
from jawenv.kernels.noise import fill_normals
from jawenv.kernels.records import record_dtype
from jawenv.kernels.vec3 import norm
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import angle_rates, split
from jawenv.reality.options import RealityRecord
from jawenv.reality.sensors import biased, fail, play
from jawenv.reality.tissue import update_tissue

_CELL, _ENCODERS = 6, 24
# Ticks to which the random numbers of an episode's beginning belong.
START_TICK, FIRST_READING_TICK, REALITY_TICK = -1, -2, -3


class Shared(NamedTuple):
    """Records that all worlds of an environment share."""

    devices: NDArray[np.void]
    """One record of dtype ``DEVICE``."""
    settings: NDArray[np.void]
    """One record of dtype ``settings_dtype``."""
    scratches: NDArray[np.void]
    """Working memory, dtype ``scratch_dtype``, one for each thread."""


class StepRows(NamedTuple):
    """The rows of each of N worlds that a step fills."""

    ticks: NDArray[np.void]
    """(N, any number) records of dtype ``ROW``, of the first ticks."""
    paths: NDArray[np.void]
    """(N, any number) records of dtype ``true_tick_dtype``, of the last ticks."""
    observation: NDArray[np.float32]
    """(N, size)."""


@cache
def scratch_dtype(
    n_muscles: int, n_lines: int, n_states: int, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of ``Scratch``."""
    return record_dtype(
        Scratch,
        filter=filter_scratch_dtype(n_muscles, n_lines, n_states, n_nuisances, n_disturbance),
        seeing=seeing_dtype(n_lines),
        observation=Parts(2 * n_muscles).size,
        lines=n_lines,
        parameters=2 * n_muscles,
    )


@njit
def _read_load_cell(device: DeviceRecord, truth: Truth, scratch: Scratch):
    """Samples of the load cell or its substitute: errors of the episode, fresh noise for each sample."""
    for i in range(N_SAMPLES):
        for k in range(6):
            noise = device.cell_force if k < 3 else device.cell_moment
            value = scratch.wrench[i, k] / (1.0 + truth.cell_gain)
            scratch.samples[i, k] = value + noise * scratch.normals[_CELL + 6 * i + k]
    if truth.no_cell:
        read_force(device, truth.jaw, truth, TICK, scratch.samples)
    biased(truth.reality, scratch.samples)
    _turn_samples(truth, scratch.samples)


@njit
def _turn_samples(truth: Truth, samples):
    """Turn the load cell's ``samples`` (3, 6) of the last tick by the mouthpiece's seat, and add the cell's offset."""
    q, u = split(truth.state)
    turning = angle_rates(q, (u[2], u[3], u[4]))
    back = -0.5 * TICK
    pose = q[0] + back * u[0], q[1] + back * u[1], q[2] + back * turning[0], q[3] + back * turning[1]
    for i in range(N_SAMPLES):
        turn_wrench(truth.cell_turn, -1.0, samples[i])
        add_offset(truth.cell_offset, 1.0, pose, samples[i])


@njit
def sense(device: DeviceRecord, truth: Truth, scratch: Scratch, reality: RealityRecord):
    """Encoder readings of the true motion, with the noise in ``scratch.normals``, into ``scratch.measured``."""
    normals = scratch.normals
    measure(truth.jaw, truth.state, scratch.rows, scratch.measured)
    scratch.measured[2] += truth.lift[0]
    scratch.measured[8] += truth.lift[1]
    turn_readings(truth.turn, -1.0, scratch.measured, scratch.measured)
    play(reality, truth.reality, scratch.measured)
    for i in range(3):
        scratch.measured[i] += device.encoder_position * normals[_ENCODERS + i]
        scratch.measured[3 + i] += device.encoder_angle * normals[_ENCODERS + 3 + i]
        scratch.measured[6 + i] += device.encoder_velocity * normals[_ENCODERS + 6 + i]
        scratch.measured[9 + i] += device.encoder_rate * normals[_ENCODERS + 9 + i]


@njit_within
def command(device: DeviceRecord, model: Jaw, known: Known, action, settings: Settings, scratch: Scratch):
    """The motors' command of the next tick, into ``scratch.action``: the action, or the law that follows targets."""
    control, tracker = settings.control, known.tracker
    if not control.targets:
        scratch.action[:] = action
    elif known.tick % LAW_TICKS == 0:
        dt = LAW_TICKS * TICK
        if known.tick % control.ticks_per_step == 0:
            aim(tracker, action, control.ticks_per_step * TICK)
        observe_world(device, model, known, control, settings.filter, scratch.seeing, scratch.observation)
        parameters = settings.filter.prior_mean.shape[0]
        follow(device, scratch.observation, parameters, tracker, True, True, dt, scratch.action)
        move_targets(tracker, dt)


@njit
def _draw_unmodelled(device: DeviceRecord, truth: Truth, tick, decay, normals):
    """The unmodelled wrench of the tick: anew, or with memory, and as large in the mean from the first tick on."""
    memory = decay if tick > 0 else 0.0
    share = sqrt(1.0 - memory * memory)
    for k in range(6):
        sd = device.unmodelled_force if k < 3 else device.unmodelled_moment
        truth.unmodelled[k] = memory * truth.unmodelled[k] + share * (sd * normals[k])


@njit
def begin_tick(device: DeviceRecord, model: Jaw, world: World, action, settings: Settings, scratch: Scratch):
    """Draw the tick's noise and let the motors take their command."""
    truth, known = world.truth, world.known
    command(device, model, known, action, settings, scratch)
    fill_normals((truth.key[0], truth.key[1]), known.tick, scratch.normals)
    normals = scratch.normals
    q, u = split(truth.state)
    motion = q, u, lift_of(truth)
    command_motors(device, truth.jaw, known.motors, motion, scratch.action, settings.control.servo, TICK)
    update_tissue(settings.reality, truth.reality, truth.jaw, truth.muscles, motion, TICK, scratch.effective)
    _draw_unmodelled(device, truth, known.tick, settings.unmodelled_decay, normals)


@njit_within
def begin_first_tick(truth: Truth, scratch: Scratch):
    """Noise of the first reading, at which the encoders alone are read: nothing has moved, and no wrench has acted."""
    fill_normals((truth.key[0], truth.key[1]), FIRST_READING_TICK, scratch.normals)
    scratch.wrench[:, :] = 0.0
    scratch.samples[:, :] = np.nan


@njit_within
def end_tick(device: DeviceRecord, model: Jaw, world: World, settings: Settings, scratch: Scratch, ticks, path):
    """Encoders and filter after the motion of a tick, or at the start; what was read is kept in ``ticks``."""
    truth, known = world.truth, world.known
    sense(device, truth, scratch, settings.reality)
    key, tick = (truth.key[0], truth.key[1]), known.tick if known.tick >= 0 else FIRST_READING_TICK
    fail(settings.reality, truth.reality, key, tick, scratch.measured, scratch.samples, scratch.faults)
    known.tick += 1
    keep_truth(truth, known.tick, scratch.wrench, known.belief.trend, path)
    read(model, known, settings, scratch, ticks)


@njit_within
def read(model: Jaw, known: Known, settings: Settings, scratch: Scratch, ticks):
    """The filter takes the readings in ``scratch``, which are kept in ``ticks``."""
    measured, samples = scratch.measured, scratch.samples
    keep_reading(known.tick, measured, samples, settings.filter.used, ticks)
    beliefs, tick = (known.belief, known.kept), known.tick
    left_out, refused = filter_tick(model, beliefs, ticks, tick, measured, samples, settings.filter, scratch.filter)
    if known.tick > 0:
        share = 1.0 / settings.control.ticks_per_step
        known.left_out += share * left_out / settings.channels
        known.gated += share * refused
        for k in range(6):
            known.reading[k] = mean_reading(scratch.filter.samples, k)


@njit_within
def end_step(device: DeviceRecord, model: Jaw, world: World, settings: Settings, scratch: Scratch, row):
    """Belief at the end of a control period, its information, and the observation, into ``row``."""
    known = world.known
    if known.tick > 0 and not settings.filter.motion_only:
        conclude(known.belief, settings.filter, scratch.filter.belief)
    refresh_information(world, scratch.matrix, scratch.right)
    observe_world(device, model, known, settings.control, settings.filter, scratch.seeing, row)


@njit
def take_motion(device: DeviceRecord, world: World, scratch: Scratch, share, acted):
    """Load cell, discomfort and governor of a tick that has passed; ``share`` is its share of the step."""
    _read_load_cell(device, world.truth, scratch)
    _take_comfort(world, scratch, share)
    world.truth.governor += share if acted > 0.0 else 0.0


@njit
def _take_comfort(world: World, scratch: Scratch, share):
    """Add one tick's discomfort to the step's record."""
    truth, limits = world.truth, world.known.limits
    q, u = split(truth.state)
    force = norm(mean_force(scratch.wrench))
    motion = q, u, lift_of(truth)
    used_fractions(truth.jaw, scratch.effective, limits, limits.tension, motion, force, scratch.fractions)
    for i in range(N_LIMITS):
        fraction = scratch.fractions[i]
        truth.fractions[i] = max(truth.fractions[i], fraction)
        truth.costs[i] += share * cost_of(fraction, limits.hard[i])
        if not fraction <= limits.hard[i]:
            truth.violated = True


@njit
def clear_step(world: World):
    """Reset the discomfort and governor record of the last step."""
    truth, known = world.truth, world.known
    truth.fractions[:] = 0.0
    truth.costs[:] = 0.0
    truth.governor = 0.0
    known.left_out = 0.0
    known.gated = 0.0


@njit_within
def advance_world(shared: Shared, model: Jaw, world: World, action, scratch: Scratch, rows: StepRows, i):
    """Advance one world by one control period, or read its sensors for the first time; its rows are number ``i``."""
    device, settings = shared.devices[0], shared.settings[0]
    begins, number = world.known.tick < 0, settings.control.ticks_per_step
    clear_step(world)
    for _ in range(1 if begins else number):
        if begins:
            begin_first_tick(world.truth, scratch)
        else:
            begin_tick(device, model, world, action, settings, scratch)
            acted = true_motion(device, world, scratch, settings)
            take_motion(device, world, scratch, 1.0 / number, acted)
        end_tick(device, model, world, settings, scratch, rows.ticks[i], rows.paths[i])
    end_step(device, model, world, settings, scratch, rows.observation[i])


@world_kernel(position=2)
def advance(shared: Shared, models, worlds, actions, active, rows: StepRows, part):
    """Advance every active world by one control period; one that has just begun gets its first reading alone.

    Args:
        shared: See ``Shared``.
        models: Jaws as the filter believes them, one for each world, dtype ``jaw_dtype``.
        worlds: Worlds, dtype ``world_dtype``; changed in place.
        actions: (N, 4) in [-1, 1], of the motors or, in targets control, the channels.
        active: (N,) bool; a world that is not active stays as it is.
        rows: See ``StepRows``; filled where a world is active.
        part: First world, one past the last, and number of the thread (``compiled.WorldKernel``).
    """
    first, last, thread = part
    for i in range(first, last):
        if active[i]:
            advance_world(shared, models[i], worlds[i], actions[i], shared.scratches[thread], rows, i)
