"""A jaw that is led along a prescribed motion: the thesis's "input the trajectory and sense the force" (chapter 5).

The motion is given as a function of time, and the device's wrench follows from the equations of motion. So the true
motion is known without a controller, at any rate of sampling, and one motion serves any number of noisy recordings.
The environment's maneuvers, in contrast, are driven by force: their motion differs from episode to episode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Prior
from jawenv.device.device import Device
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.mechanics.dynamics import N_WRENCH, acceleration_kernel
from jawenv.mechanics.kinematics import turning_axes
from jawenv.recordings import defaults
from jawenv.recordings.record import Record

Array = NDArray[np.float64]

COORDINATES = ("x", "y", "theta", "psi", "alpha")
SLIDE = 13e-3 / np.radians(35.0)  # m of the condyle per rad of opening, as a healthy jaw has it
ARM = 0.03  # m: a moment counts as much as the force that has it at this arm, in the choice among wrenches
_DIFFERENCE = 1e-5  # s
_START_SD = (1e-3, 0.0175, 1e-3, 0.01)  # as the environment: 1 mm, 1 degree, 1 mm/s, 0.01 rad/s


@dataclass(frozen=True)
class PrescribedMotion:
    """A motion by keyframes, each coordinate at rest in each of them and smooth between (quintic polynomials)."""

    keyframes: Mapping[str, tuple[Sequence[float], Sequence[float]]]
    """Coordinate -> (seconds, values in m or rad); a coordinate that is not named stays 0."""

    @property
    def duration(self) -> float:
        """S until the last keyframe."""
        return max(times[-1] for times, _ in self.keyframes.values())

    def at(self, time: Array) -> tuple[Array, Array]:
        """(N, 5) coordinates and their rates at N times."""
        q, rate = np.zeros((len(time), 5)), np.zeros((len(time), 5))
        for name, (times, values) in self.keyframes.items():
            i = COORDINATES.index(name)
            q[:, i], rate[:, i] = _smooth(time, np.asarray(times), np.asarray(values))
        return q, rate

    def speeds(self, time: Array) -> tuple[Array, Array]:
        """(N, 5) coordinates q and speeds u = (x', y', angular velocity in body axes) at N times."""
        q, rate = self.at(time)
        u = rate.copy()
        for k, (pose, turn) in enumerate(zip(q, rate, strict=True)):
            axes = np.array(turning_axes(tuple(pose)))
            u[k, 2:] = turn[2] * axes[0] + turn[3] * axes[1] + turn[4] * axes[2]
        return q, u


def _smooth(time: Array, times: Array, values: Array) -> tuple[Array, Array]:
    """Quintic steps from keyframe to keyframe, and their rate."""
    interval = np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 2)
    length = times[interval + 1] - times[interval]
    s = np.clip((time - times[interval]) / length, 0.0, 1.0)
    rise = values[interval + 1] - values[interval]
    value = values[interval] + rise * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return value, rise * 30.0 * (s * (1.0 - s)) ** 2 / length


def _wrench_of(jaw: Any, muscles: Array, motion: PrescribedMotion, time: Array) -> Array:
    """(N, 6) wrench on the mouthpiece, body axes, that gives the motion; the smallest one, as there is one too many.

    The accelerations are linear in the wrench, so that two evaluations per component say all.
    """
    q, u = motion.speeds(time)
    _, before = motion.speeds(time - _DIFFERENCE)
    _, after = motion.speeds(time + _DIFFERENCE)
    acceleration = (after - before) / (2.0 * _DIFFERENCE)
    free = defaults.start_sd(jaw)[5:] > 0.0
    sizes = np.repeat([1.0, ARM], 3)
    units = [tuple(row) for row in np.eye(N_WRENCH)]
    wrench = np.zeros((len(time), N_WRENCH))
    for k in range(len(time)):
        pose, speed = tuple(q[k]), tuple(u[k])
        alone = np.array(acceleration_kernel(jaw, muscles, pose, speed, (0.0,) * N_WRENCH))
        by_wrench = np.array([acceleration_kernel(jaw, muscles, pose, speed, unit) for unit in units]) - alone
        effect = (by_wrench.T * sizes)[free]
        wrench[k] = sizes * np.linalg.lstsq(effect, (acceleration[k] - alone)[free], rcond=None)[0]
    return wrench


def lead(
    jaw: Any,
    log_parameters: Array,
    names: tuple[str, ...],
    prior: Prior,
    motion: PrescribedMotion,
    dt: float,
    device: Device,
) -> Record:
    """The record of a motion without any noise in it; ``with_noise`` makes recordings of it.

    Args:
        jaw: geometry, true and believed alike.
        log_parameters: (p,) the truth.
        names: of the p parameters.
        prior: belief about them.
        motion: at rest in its first keyframe.
        dt: length of a tick, s.
        device: source of the noise levels for the estimators.
    """
    ticks = round(motion.duration / dt)
    half: Array = 0.5 * dt * np.arange(2.0 * ticks + 1.0)
    time = half[::2].copy()
    q, u = motion.speeds(time)
    states = np.hstack([q, u])
    muscles = np.exp(log_parameters.reshape(-1, 2))[jaw["muscle"]]
    wrench = _wrench_of(jaw, muscles, motion, half)
    wrenches = np.stack([wrench[:-2:2], wrench[1::2], wrench[2::2]], axis=1)
    rows, measured = np.zeros((N_MEASUREMENTS, states.shape[1])), np.zeros((ticks + 1, N_MEASUREMENTS))
    for k in range(ticks + 1):
        measure(jaw, states[k], rows, measured[k])
    free = defaults.start_sd(jaw) > 0.0
    return Record(
        time=time,
        measured=measured,
        samples=wrenches.copy(),
        start_mean=states[0].copy(),
        start_sd=free * np.repeat(_START_SD, [2, 3, 2, 3]),
        measurement_sd=defaults.measurement_sd(device),
        wrench_sd=defaults.wrench_sd(device, dt),
        cell_sd=defaults.cell_sd(device),
        gain_sd=device.cell_gain,
        jaw=jaw,
        prior=prior,
        parameter_names=names,
        truth=log_parameters,
        states=states,
        wrenches=wrenches,
    )


def with_noise(record: Record, device: Device, rng: np.random.Generator) -> Record:
    """A recording of a noise-free one: noise of encoders and load cell, its gain error, an unmodelled wrench.

    The motion stays as it is: the device makes up for the unmodelled wrench, and reads that.
    """
    ticks = len(record.samples)
    arrays = device.records()[0]
    shape = (ticks, 1, 3)
    scale = np.sqrt(defaults.UNMODELLED_TIME / record.dt)
    unmodelled = np.concatenate(
        [scale * float(arrays[f"unmodelled_{kind}"]) * rng.normal(size=shape) for kind in ("force", "moment")], axis=-1
    )
    gain = record.gain_sd * rng.normal()
    assert record.wrenches is not None and record.states is not None, "a prescribed motion has both"
    wrenches = record.wrenches - unmodelled
    cell = np.repeat([float(arrays["cell_force"]), float(arrays["cell_moment"])], 3)
    samples = wrenches / (1.0 + gain) + cell * rng.normal(size=wrenches.shape)
    measured = record.measured + record.measurement_sd * rng.normal(size=record.measured.shape)
    start = record.states[0] + record.start_sd * rng.normal(size=record.start_sd.shape)
    return replace(record, measured=measured, samples=samples, wrenches=wrenches, start_mean=start)
