"""The filter's settings from patient, device and disturbance, filled here alone, and the prior of its motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import MuscleSet
from jawenv.anatomy.knowledge import Knowledge
from jawenv.device.device import Device
from jawenv.device.force_sensor import ForceSensor, device_with_sensor, friction_noise
from jawenv.filter.model.basis import build_basis
from jawenv.filter.readings import least_noise
from jawenv.filter.readings.screening import rough_change
from jawenv.mechanics.dynamics import N_WRENCH

PLACE_SD, ANGLE_SD, VELOCITY_SD, RATE_SD = 1e-3, 0.0175, 1e-3, 0.01  # 1 mm, 1 degree, 1 mm/s, 0.01 rad/s


def start_sd(jaw: Any) -> NDArray[np.float64]:
    """(10,) sds of (q, u) of the record of a jaw; 0 for what is held."""
    # Pitch (theta, and the second of the angular velocities) is always free, yaw and roll both or none.
    turns = bool(jaw["inertia_contact_inverse"][2, 2] > 0.0)
    places = [bool(jaw["free_x"]), bool(jaw["free_y"])]
    free = np.array([*places, True, turns, turns, *places, turns, True, turns])
    sds: NDArray[np.float64] = free * np.repeat([PLACE_SD, ANGLE_SD, VELOCITY_SD, RATE_SD], [2, 3, 2, 3])
    return sds


if TYPE_CHECKING:
    from jawenv.filter.nuisances.unknowns import Values

Array = NDArray[np.float64]


MODEL_ERROR = 2e-3
"""Share of the force that is carried which the filter may have wrong at a pose (G): its own errors of second order."""

MODEL_ERROR_EXACT = 6e-4
"""The same with a known anatomy, as readings count for less."""

FULL_WEIGHT_TICKS = 1500.0
"""Ticks at a pose that count in full where muscles and white noise are all that is unknown."""


class Geometry(NamedTuple):
    """A patient as the filter knows him."""

    jaw: Any  # record of dtype ``jaw_dtype``
    muscles: MuscleSet | None  # the jaw's; they matter where there are nuisances
    prior: Any  # of the parameters
    knowledge: Knowledge  # what is known within sds
    sds: list[Values]  # one sd of each nuisance, as ``directions`` gives them
    upright: Any  # the jaw about which sds are taken
    force: tuple[Array, Any] | None = None
    """Sds of the errors of a force that no load cell reads, and the device's record; None where one does."""


class Noise(NamedTuple):
    """Noise of a device and of the disturbance, as the filter believes them."""

    dt: float  # length of a tick, s
    measurement_sd: Array  # (12,) of the encoders
    wrench_variance: Array  # (6,) of the wrench that is new in every tick
    cell_sd: Array  # (6,) of a reading of the load cell, as half of its variance
    gain_sd: float  # of the load cell
    disturbance_sd: Array  # (6,) of the wrench that lasts
    disturbance_time_s: float  # for how long; 0 where none lasts


def wrench_variances(device: Device, force_sensor: ForceSensor) -> Array:
    """(12,) of the wrench not known in a tick of 10 ms: constant over it, and tilting."""
    record = device_with_sensor(force_sensor, device)[0]
    # Simpson's weights (1, 4, 1)/6 leave half the variance of one sample.
    cell_force, cell_moment = 0.5 * float(record["cell_force"]) ** 2, 0.5 * float(record["cell_moment"]) ** 2
    unmodelled = float(record["unmodelled_force"]) ** 2, float(record["unmodelled_moment"]) ** 2
    friction = friction_noise(force_sensor, device)
    squares = [unmodelled[k] + friction[k] ** 2 + (cell_force, cell_moment)[k] for k in range(2)]
    constant = least_noise.wrench_variance(np.repeat(squares, 3))
    # Squares of their roots: a record has the sds, and its filter must have these numbers to the bit.
    variance: Array = np.sqrt([*constant, *np.repeat([cell_force, cell_moment], 3)]) ** 2
    return variance


def noise_of(device: Device, force_sensor: ForceSensor, dt: float) -> Noise:
    """The filter's noise for a device in ticks of ``dt`` (10 ms)."""
    record, variances = device_with_sensor(force_sensor, device)[0], wrench_variances(device, force_sensor)
    time = float(record["unmodelled_time"])
    remembered = np.repeat([float(record[f"unmodelled_{kind}"]) for kind in ("force", "moment")], 3)
    new = variances[:N_WRENCH]
    if time > 0.0:
        new = least_noise.wrench_variance(new - remembered**2)
    cell_sd = np.sqrt(variances[N_WRENCH:])
    return Noise(dt, least_noise.encoder_sds(record), new, cell_sd, float(record["cell_gain"]), remembered, time)


def used_readings(sensors: str) -> NDArray[np.bool_]:
    """(12,) which of the encoders' readings ``"pose"`` or ``"point"`` sensors have."""
    point = [True] * 3 + [False] * 3 + [True] * 3 + [False] * 3
    return np.array([True] * 12 if sensors == "pose" else point)


def fill_settings(settings: Any, geometry: Geometry, noise: Noise, start_sd: Array) -> None:
    """Fill a record of dtype ``filter_settings_dtype``, but for which readings are ``used``.

    Args:
        settings: written.
        geometry: of the patient.
        noise: of the device.
        start_sd: (n,) of the motion at the start.
    """
    settings["dt"], settings["gain_variance"] = noise.dt, noise.gain_sd**2
    settings["model_error"] = MODEL_ERROR
    imaged = bool(geometry.sds) and geometry.knowledge != Knowledge()
    settings["systematic_error"] = MODEL_ERROR if imaged else MODEL_ERROR_EXACT
    settings["full_weight_ticks"] = 0.0 if geometry.sds or noise.disturbance_time_s > 0.0 else FULL_WEIGHT_TICKS
    settings["measurement_variance"] = noise.measurement_sd**2
    settings["wrench_variance"] = noise.wrench_variance
    settings["start_sd"][: len(start_sd)] = start_sd
    settings["cell_repeats"] = least_noise.cell_repeats(noise.cell_sd)
    settings["rough"] = rough_change(noise.cell_sd, noise.dt)
    settings["basis"] = build_basis(geometry.jaw, geometry.prior)[0]
    settings["prior_mean"], settings["prior_sd"] = geometry.prior.mean, geometry.prior.sd
    if geometry.sds:
        from jawenv.filter.nuisances.records import write_nuisances

        assert geometry.muscles is not None
        parts = geometry.upright, geometry.knowledge, geometry.muscles, geometry.sds
        write_nuisances(settings["nuisances"], *parts, geometry.force)
    if noise.disturbance_time_s > 0.0:
        variance = noise.disturbance_sd**2
        settings["start_sd"][-N_WRENCH:] = np.sqrt(variance)
        settings["disturbance_decay"] = np.exp(-noise.dt / noise.disturbance_time_s)
        settings["disturbance_variance"] = variance * -np.expm1(-2.0 * noise.dt / noise.disturbance_time_s)
