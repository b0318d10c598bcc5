"""Worlds whose true jaw is a rigid body in contact, moved by pymunk; device, sensors and filter stay compiled.

pymunk runs in Python, one jaw after another, so each tick is taken in three parts: the motors' command (compiled), the
motion (pymunk, asking the compiled device for its wrench at every step), and load cell, filter and comfort (compiled).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.device.motors import device_wrench
from jawenv.envs.world.load_cell import add_moments, clear_moments
from jawenv.envs.world.plants import TICK, end_motion, lift_of, plus_wrench
from jawenv.envs.world.record import Truth
from jawenv.envs.world.step_kernel import (
    StepRows,
    begin_first_tick,
    begin_tick,
    clear_step,
    end_step,
    end_tick,
    scratch_dtype,
    take_motion,
)
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import record_zeros
from jawenv.kernels.vec3 import apply
from jawenv.mechanics.kinematics import fossa, rotation, split
from jawenv.mechanics.sagittal_forces import turned
from jawenv.reality.joint import tissue_push


@njit
def take_planar(truth: Truth, x, z, theta, x_rate, z_rate, theta_rate):
    """Set the midline coordinates and the lift of ``truth`` from a motion in the sagittal plane."""
    height, slope, _, _ = fossa(truth.jaw, x)
    for i in range(10):
        truth.state[i] = 0.0
    truth.state[0], truth.state[2] = x, theta
    truth.state[5], truth.state[8] = x_rate, theta_rate
    truth.lift[0], truth.lift[1] = z - height, z_rate - slope * x_rate


@njit
def contact_begin(devices, models, worlds, i, actions, all_settings, scratches):
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
def contact_wrench(devices, worlds, i, all_settings, scratches, step, motion):
    """Device and unmodelled wrench on world i: force forward and up (N), pitch moment (N m), as ``WrenchAt`` says.

    It acts for a ``step`` (s); ``motion`` is the mouthpiece's place and velocity, theta and its rate, and when the step
    ends, as ``WrenchAt`` takes them.
    """
    point, velocity, theta, theta_rate, since = motion
    device, truth, known, scratch, settings = (
        devices[0],
        worlds[i].truth,
        worlds[i].known,
        scratches[i],
        all_settings[0],
    )
    arm_x, arm_z = turned(truth.jaw.mouthpiece, theta)
    x_rate, z_rate = velocity[0] - theta_rate * arm_z, velocity[1] + theta_rate * arm_x
    take_planar(truth, point[0] - arm_x, point[1] - arm_z, theta, x_rate, z_rate, theta_rate)
    q, u = split(truth.state)
    lift, servo = lift_of(truth), settings.control.servo
    wrench, acted = device_wrench(device, truth.jaw, known.limits, known.motors, (q, u, lift), since, servo)
    scratch.acted = max(scratch.acted, acted)
    add_moments(scratch.wrench, wrench, step / TICK, (2.0 * since - step) / TICK - 1.0)
    push = tissue_push(settings.reality, known.limits, truth.jaw, q, lift)
    total = plus_wrench(wrench, truth.unmodelled, push)
    force = apply(rotation(q), (total[0], total[1], total[2]))
    return force[0], force[2], total[4]


@njit
def contact_end(devices, models, worlds, i, all_settings, scratches, rows: StepRows, motion):
    """Sensors, filter and comfort of one tick of world i, whose jaw has come to ``motion``; or its first reading."""
    device, world, settings, scratch = devices[0], worlds[i], all_settings[0], scratches[i]
    if world.known.tick < 0:
        begin_first_tick(world.truth, scratch)
    else:
        take_planar(world.truth, motion[0], motion[1], motion[2], motion[3], motion[4], motion[5])
        acted = max(scratch.acted, end_motion(device, world, scratch, settings.control.servo))
        take_motion(device, world, scratch, 1.0 / settings.control.ticks_per_step, acted)
    end_tick(device, models[i], world, settings, scratch, rows.ticks[i], rows.paths[i])


@njit
def contact_clear(worlds, i):
    """Forget the last step's discomfort of world i."""
    clear_step(worlds[i])


@njit
def contact_inform(devices, models, worlds, i, all_settings, scratches, observation):
    """Belief of world i, what it is worth, and what is seen, at a step's end."""
    end_step(devices[0], models[i], worlds[i], all_settings[0], scratches[i], observation[i])


class ContactPlants:
    """The pymunk jaws of N worlds.

    Args:
        device: One record of dtype ``DEVICE``, in an array.
        models: The filter's jaws.
        worlds: The worlds.
        settings: One record of dtype ``settings_dtype``, in an array.
        ticks: What they have read, tick by tick.
        paths: What was true then.
        observation: (N, size) float32, filled where a world is moved.
        sizes: Numbers of muscles, lines, states of motion and nodes of the basis.
    """

    def __init__(
        self,
        device: Any,
        models: Any,
        worlds: Any,
        settings: Any,
        ticks: Any,
        paths: Any,
        observation: Any,
        sizes: tuple[int, int, int, int, int],
    ) -> None:
        """Allocate working memory; the jaws are made when their worlds are reset."""
        self._device, self._models, self._worlds, self._settings = device, models, worlds, settings
        self._ticks, self._paths, self._observation = ticks, paths, observation
        self._scratches = record_zeros(len(worlds), scratch_dtype(*sizes))
        self._jaws: list[Any] = [None] * len(worlds)

    def reset(self, chosen: NDArray[np.bool_]) -> None:
        """Put the jaws of the chosen worlds on their fossae, at rest where the midline model rests, and read them."""
        from jawenv.mechanics.sagittal import SagittalJaw

        jaws = list(self._jaws)
        for i in np.flatnonzero(chosen):
            truth = self._worlds["truth"][i]
            jaw = SagittalJaw(truth["jaw"], truth["muscles"])
            x, theta = truth["state"][0], truth["state"][2]
            jaw.place((x, fossa(truth["jaw"], x)[0], theta, 0.0, 0.0, 0.0))
            jaws[i] = jaw
            self._end_tick(int(i), jaw)
            self._inform(int(i))
        self._jaws = jaws

    def advance(self, actions: NDArray[np.float64], active: NDArray[np.bool_]) -> None:
        """One control period of every active world with ``actions`` (N, 4)."""
        for i in np.flatnonzero(active):
            self._advance_world(int(i), actions)

    def _advance_world(self, i: int, actions: NDArray[np.float64]) -> None:
        device, worlds, settings, scratches = self._device, self._worlds, self._settings, self._scratches
        jaw = self._jaws[i]

        def wrench_at(*motion: Any) -> tuple[float, float, float]:
            wrench: tuple[float, float, float]
            wrench = contact_wrench(device, worlds, i, settings, scratches, jaw.step, motion)
            return wrench

        jaw.forget_contacts()  # so that a copy of the environment, made between two steps, goes on alike
        contact_clear(worlds, i)
        for _ in range(int(settings["control"]["ticks_per_step"][0])):
            contact_begin(device, self._models, worlds, i, actions, settings, scratches)
            jaw.muscles[:] = scratches["effective"][i]
            jaw.advance(TICK, wrench_at)
            self._end_tick(i, jaw)
        self._inform(i)

    def _end_tick(self, i: int, jaw: Any) -> None:
        rows, motion = StepRows(self._ticks, self._paths, self._observation), tuple(jaw.state)
        contact_end(self._device, self._models, self._worlds, i, self._settings, self._scratches, rows, motion)

    def _inform(self, i: int) -> None:
        scratches, seen = self._scratches, self._observation
        contact_inform(self._device, self._models, self._worlds, i, self._settings, scratches, seen)
