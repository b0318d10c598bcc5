"""The world's clock: one control period of every world, estimator included, in one compiled call."""

from __future__ import annotations

import numpy as np
from numba import get_thread_id, prange

from jawenv.compiled import njit, njit_parallel
from jawenv.device.comfort import HARD, N_LIMITS, cost_of, used_fractions
from jawenv.device.motors import command_motors, device_wrench
from jawenv.envs.belief import refresh_information
from jawenv.estimation.ekf import (
    FILTER_SCRATCH,
    N_MEASUREMENTS,
    measure,
    parameter_variance,
    predict,
    predict_covariance,
    propagate,
    update,
    update_covariance,
)
from jawenv.estimation.sensitivity import plus
from jawenv.mechanics.dynamics import N_STATES, state_rate
from jawenv.mechanics.kinematics import split
from jawenv.noise import fill_normals

TICK = 0.01  # s: sensors, filter and motor commands run at 100 Hz
SUBSTEPS = 4  # Runge-Kutta steps of the true motion per tick
N_NORMALS = 24  # 6 unmodelled wrench, 6 load cell, 12 encoders

SETTINGS = np.dtype(
    [
        ("trajectory", "u1"),
        ("bound", "u1"),
        ("used", "u1", N_MEASUREMENTS),
        ("measurement_variance", "f8", N_MEASUREMENTS),
        ("wrench_variance", "f8", 6),
        ("parameter_rate", "f8"),
        ("parameter_time", "f8"),
        ("prior_mean", "f8", 12),
        ("prior_sd", "f8", 12),
        ("steps", "i8"),
        ("ticks_per_step", "i8"),
    ],
    align=True,
)

SCRATCH = np.dtype(
    [
        ("filter", FILTER_SCRATCH),
        ("normals", "f8", N_NORMALS),
        ("measured", "f8", N_MEASUREMENTS),
        ("reading", "f8", 6),
        ("unmodelled", "f8", 6),
        ("mean_wrench", "f8", 6),
        ("fractions", "f8", N_LIMITS),
        ("matrix", "f8", (12, 12)),
        ("right", "f8", 12),
    ],
    align=True,
)


@njit
def true_motion(device, world, scratch, trajectory):  # type: ignore[no-untyped-def]
    """Move the jaw through one tick; leaves the device's mean wrench in ``scratch.mean_wrench``, returns the governor's."""
    extra, mean = scratch.unmodelled, scratch.mean_wrench
    for k in range(6):
        mean[k] = 0.0
    acted = 0.0
    h = TICK / SUBSTEPS
    for substep in range(SUBSTEPS):
        start_q, start_u = split(world.state)
        q, u = start_q, start_u
        sum_q, sum_u = (0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0)
        for stage in range(4):
            since = substep * h + (0.0 if stage == 0 else (h if stage == 3 else 0.5 * h))
            wrench, governed = device_wrench(
                device, world.jaw, world.limits, world.motors, q, u, since, trajectory
            )
            acted = max(acted, governed)
            weight = h / 3.0 if stage == 1 or stage == 2 else h / 6.0
            for k in range(6):
                mean[k] += wrench[k] * (weight / TICK)
            total = (
                wrench[0] + extra[0],
                wrench[1] + extra[1],
                wrench[2] + extra[2],
                wrench[3] + extra[3],
                wrench[4] + extra[4],
                wrench[5] + extra[5],
            )
            q_rate, u_rate = state_rate(world.jaw, world.muscles, q, u, total)
            sum_q, sum_u = plus(sum_q, weight, q_rate), plus(sum_u, weight, u_rate)
            reach = h if stage == 2 else 0.5 * h
            q, u = plus(start_q, reach, q_rate), plus(start_u, reach, u_rate)
        for i in range(5):
            world.state[i] = start_q[i] + sum_q[i]
            world.state[5 + i] = start_u[i] + sum_u[i]
    if trajectory:
        for i in range(4):
            world.motors.target[i] += world.motors.rate[i] * TICK
    return acted


@njit
def sense(device, world, scratch):  # type: ignore[no-untyped-def]
    """Encoder readings of the true motion, with the noise in ``scratch.normals``, into ``scratch.measured``."""
    normals = scratch.normals
    measure(world.jaw, world.state, scratch.filter.rows, scratch.measured)
    for i in range(3):
        scratch.measured[i] += device.encoder_position * normals[12 + i]
        scratch.measured[3 + i] += device.encoder_angle * normals[15 + i]
        scratch.measured[6 + i] += device.encoder_velocity * normals[18 + i]
        scratch.measured[9 + i] += device.encoder_rate * normals[21 + i]


@njit
def advance_tick(device, model, world, action, settings, scratch):  # type: ignore[no-untyped-def]
    """One tick of one world: command, motion, load cell, prediction, encoders, update, comfort."""
    fill_normals((world.key[0], world.key[1]), world.tick, scratch.normals)
    normals = scratch.normals
    q, u = split(world.state)
    command_motors(device, world.jaw, world.motors, q, u, action, settings.trajectory, TICK)
    for k in range(3):
        scratch.unmodelled[k] = device.unmodelled_force * normals[k]
        scratch.unmodelled[3 + k] = device.unmodelled_moment * normals[3 + k]
    for i in range(N_STATES):
        scratch.filter.state[i] = world.state[i]
    acted = true_motion(device, world, scratch, settings.trajectory)
    for k in range(3):
        scratch.reading[k] = (
            scratch.mean_wrench[k] / (1.0 + world.cell_gain) + device.cell_force * normals[6 + k]
        )
        scratch.reading[3 + k] = (
            scratch.mean_wrench[3 + k] / (1.0 + world.cell_gain) + device.cell_moment * normals[9 + k]
        )
    time = world.tick * TICK
    if settings.bound:
        # scratch.filter.state still holds the true state at the start of the tick.
        wrench = scratch.mean_wrench
        total = (wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5])
        propagate(model, world.muscles, scratch.filter.state, total, TICK, scratch.filter)
        predict_covariance(world.bound, scratch.reading, settings.wrench_variance, 0.0, scratch.filter)
        update_covariance(
            model, world.state, world.bound, settings.measurement_variance, settings.used, scratch.filter
        )
    noise = parameter_variance(settings.parameter_rate, settings.parameter_time, time, TICK)
    predict(
        model,
        world.mean,
        world.covariance,
        scratch.reading,
        TICK,
        settings.wrench_variance,
        noise,
        scratch.filter,
    )
    sense(device, world, scratch)
    update(
        model,
        world.mean,
        world.covariance,
        scratch.measured,
        settings.measurement_variance,
        settings.used,
        scratch.filter,
    )
    for k in range(6):
        world.reading[k] = scratch.reading[k]
    world.tick += 1
    return acted


@njit
def take_comfort(world, scratch, share):  # type: ignore[no-untyped-def]
    """Add one tick's discomfort to the step's record; ``share`` is the tick's share of the step."""
    q, u = split(world.state)
    mean = scratch.mean_wrench
    force = (mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]) ** 0.5
    used_fractions(world.jaw, world.muscles, world.limits, q, u, force, scratch.fractions)
    for i in range(N_LIMITS):
        fraction = scratch.fractions[i]
        world.fractions[i] = max(world.fractions[i], fraction)
        world.costs[i] += share * cost_of(fraction, HARD[i])
        if not fraction <= HARD[i]:
            world.violated = 1


@njit_parallel
def advance(devices, models, worlds, actions, active, all_settings, scratches):  # type: ignore[no-untyped-def]
    """Advance every active world by one control period.

    Args:
        devices: One record of dtype ``DEVICE``, in an array (a parallel loop takes no bare record).
        models: Jaws as the filter believes them, one for each world, dtype ``JAW``.
        worlds: Worlds, dtype ``WORLD``; changed in place.
        actions: (N, 4) in [-1, 1].
        active: (N,) bool; a world that is not active stays as it is.
        all_settings: One record of dtype ``SETTINGS``, in an array.
        scratches: Working memory, dtype ``SCRATCH``, one for each thread.
    """
    for i in prange(worlds.shape[0]):
        if not active[i]:
            continue
        device, settings = devices[0], all_settings[0]
        world, scratch = worlds[i], scratches[get_thread_id()]
        for k in range(N_LIMITS):
            world.fractions[k] = 0.0
            world.costs[k] = 0.0
        world.governor = 0.0
        share = 1.0 / settings.ticks_per_step
        for _ in range(settings.ticks_per_step):
            acted = advance_tick(device, models[i], world, actions[i], settings, scratch)
            world.governor += share * acted
            take_comfort(world, scratch, share)
        refresh_information(world, settings, scratch.matrix, scratch.right)
