"""Defaults of a recording's file: noise of the device, geometry, the motion before the first reading."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import real_number
from jawenv.device.device import Device
from jawenv.device.force_sensor import ForceSensor, device_with_sensor, friction_noise
from jawenv.envs.configuration import Configuration
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.readings import least_noise
from jawenv.ladder import MODELS, Model, model_named
from jawenv.mechanics.building import build_jaw, gravity_in_head
from jawenv.mechanics.dynamics import N_STATES

Array = NDArray[np.float64]

ANYONE = "anyone"
UNLABELLED = Configuration(cohort=ANYONE, control="force")
"""World of a recording of which nothing is told."""
BENCH = replace(UNLABELLED, knowledge="bench")
"""World of a bench's recording of which nothing is told: the anatomy is that of a scan."""
UNMODELLED_TIME = 0.01
"""s over which ``Device.unmodelled_force_N`` is constant: over a longer tick its mean is smaller."""
STEEPEST_TILT = 90.0  # degrees
# Prior sds of the motion about the closed jaw at rest, before the first reading.
POSITION_SD, ANGLE_SD, VELOCITY_SD, RATE_SD = 0.02, 0.5, 0.1, 2.0
FIT_STEPS = 20


def geometry_of(configuration: Configuration, head_tilt_deg: float = 0.0) -> Any:
    """The jaw that an environment's filter believes in, a record of dtype ``jaw_dtype``."""
    tilt = real_number(head_tilt_deg)
    if tilt is None or abs(tilt) > STEEPEST_TILT:
        raise InputError(f"head_tilt_deg is {shown(head_tilt_deg)}; allowed: -{STEEPEST_TILT:g} to {STEEPEST_TILT:g}")
    return build_jaw(
        configuration.muscles,
        configuration.mandible,
        configuration.fossa,
        free=model_named(configuration.model).free,
        head_tilt_deg=tilt,
    )


def matching_models(parameter_names: tuple[str, ...]) -> list[Model]:
    """Models with these parameters."""
    return [model for model in MODELS.values() if model.muscles.parameter_names == parameter_names]


def model_of_geometry(jaw: Any) -> tuple[str, float] | None:
    """(model, head tilt in degrees) whose ``geometry_of`` this is, to rounding; None for any other jaw."""
    tilt = tilt_of(jaw)
    for name in MODELS:
        candidate = geometry_of(Configuration(model=name))
        if candidate.dtype != jaw.dtype:
            continue
        candidate["gravity"] = gravity_in_head(float(np.linalg.norm(candidate["gravity"])), tilt)
        if all(np.allclose(candidate[field], jaw[field], rtol=1e-9, atol=1e-12) for field in jaw.dtype.names):
            return name, tilt
    return None


def tilt_of(jaw: Any) -> float:
    """Pitch of the head in a jaw's record, degrees, positive looking down."""
    return float(np.degrees(np.arctan2(jaw["gravity"][0], -jaw["gravity"][2])))


def measurement_sd(device: Device) -> Array:
    """(12,) noise of the encoders, SI; not less than filters believe (``least_noise``)."""
    return least_noise.encoder_sds(device.records()[0])


def wrench_sd(device: Device, dt: float, force_sensor: ForceSensor = "cell") -> Array:
    """(6,) sd of the wrench not known over a tick of ``dt`` seconds: the unmodelled one, and the force sensor's noise.

    The unmodelled wrench is new every ``UNMODELLED_TIME``, so its mean over a tick falls as the root of the tick's
    length; one with memory is no part of it (``disturbance_sd``). The mean of a tick's readings has half the variance
    of one: Simpson's weights (1, 4, 1)/6 of three readings, or the two ends' mean where the middle is interpolated.
    """
    share = UNMODELLED_TIME / dt
    new = 0.0 if device.unmodelled_time_s > 0.0 else disturbance_sd(device)
    friction = np.repeat(friction_noise(force_sensor, device), 3)
    variance = (new**2 + friction**2) * share + cell_sd(device, force_sensor) ** 2
    sd: Array = np.sqrt(least_noise.wrench_variance(variance))
    return sd


def disturbance_sd(device: Device) -> Array:
    """(6,) sd at any time of an unmodelled wrench with memory."""
    device_record = device.records()[0]
    sd: Array = np.repeat([float(device_record["unmodelled_force"]), float(device_record["unmodelled_moment"])], 3)
    return sd


def cell_sd(device: Device, force_sensor: ForceSensor = "cell") -> Array:
    """(6,) the force sensor's part of ``wrench_sd``."""
    device_record = device_with_sensor(force_sensor, device)[0]
    sd: Array = np.repeat([float(device_record["cell_force"]), float(device_record["cell_moment"])], 3) / np.sqrt(2.0)
    return sd


def start_sd(jaw: Any) -> Array:
    """(10,) sd of a motion of which nothing is known; 0 where the model holds a coordinate."""
    turns = float(jaw["inertia_contact_inverse"][2, 2]) > 0.0  # yaw and roll are free both or none
    places = [float(jaw["free_x"]), float(jaw["free_y"])]
    free = np.array([*places, 1.0, turns, turns, *places, turns, 1.0, turns])
    sizes = np.repeat([POSITION_SD, ANGLE_SD, VELOCITY_SD, RATE_SD], [2, 3, 2, 3])
    sd: Array = free * sizes
    return sd


def motion_of_reading(jaw: Any, measured: Array, sd: Array) -> Array:
    """The motion that explains one reading of the encoders best, by Gauss-Newton steps from the closed jaw at rest.

    Args:
        jaw: geometry.
        measured: (12,), NaN where not read.
        sd: (12,) noise of the encoders.

    Returns:
        (10,) motion (q, u). What the reading does not show stays near the closed jaw at rest.
    """
    rows, expected = np.zeros((N_MEASUREMENTS, N_STATES)), np.zeros(N_MEASUREMENTS)
    spread = start_sd(jaw)
    free, read = spread > 0.0, np.isfinite(measured)
    mean = np.zeros(N_STATES)
    for _ in range(FIT_STEPS):
        measure(jaw, mean, rows, expected)
        weighted = rows[np.ix_(read, free)] / sd[read, None]
        innovation = (measured[read] - expected[read]) / sd[read]
        normal = weighted.T @ weighted + np.diag(spread[free] ** -2.0)
        step = np.linalg.solve(normal, weighted.T @ innovation - mean[free] / spread[free] ** 2)
        mean[free] += step
        if np.abs(step).max() < 1e-12:
            break
    return mean
