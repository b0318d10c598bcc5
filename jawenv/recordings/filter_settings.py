"""Settings of the environments' filter for a geometry that is known within sds, and for a record."""

from __future__ import annotations

from typing import Any

from jawenv.device.device import TICK
from jawenv.device.force_sensor import device_with_sensor, sds_of_sensor
from jawenv.envs.configuration import Configuration
from jawenv.filter.belief.state import filter_settings_dtype
from jawenv.filter.nuisances.directions import directions
from jawenv.filter.nuisances.unknowns import Values
from jawenv.filter.settings import Geometry, Noise, fill_settings, noise_of, start_sd, used_readings
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings import defaults
from jawenv.recordings.record import Record

_OF_THE_BODY = ("mass", "centre_of_mass", "inertia", "inertia_contact_inverse", "gravity")


def _upright(jaw: Any, configuration: Configuration) -> Any:
    """The geometry about which sds are taken: mass, inertia and gravity are the environment's, the head upright."""
    upright, default = jaw.copy(), defaults.geometry_of(configuration)
    for name in _OF_THE_BODY:
        upright[name] = default[name]
    return upright


def settings_of_record(record: Record) -> Any:
    """A record's noise, prior, nuisances and disturbance, of dtype ``filter_settings_dtype``."""
    states, muscles = len(record.start_mean), len(record.parameter_names) // 2
    sds: list[Values] = []
    force, muscle_set, upright = None, None, record.jaw
    if record.force_sensor != "cell" and record.device is not None:
        motor_sds = sds_of_sensor(record.force_sensor, record.device)
        assert motor_sds is not None, "no load cell reads the force"
        force = motor_sds, record.device.records()[0]
    if not record.knowledge.exact or force is not None:
        model = defaults.matching_models(record.parameter_names)[0]
        upright, muscle_set = _upright(record.jaw, Configuration(model=model.name)), model.muscles
        parts = record.knowledge, muscle_set, upright, record.prior.mean, None if force is None else force[0]
        sds = directions(*parts, with_memory=record.disturbance_time_s > 0.0)
    lines = len(record.jaw["l_o"]) if sds else 1
    disturbance = N_WRENCH if record.disturbance_time_s > 0.0 else 0
    settings = record_zeros(1, filter_settings_dtype(muscles, states, lines, len(sds), disturbance))[0]
    settings["used"] = True
    noise = Noise(
        record.dt,
        record.measurement_sd,
        record.noise_variance[:N_WRENCH],
        record.cell_sd,
        record.gain_sd,
        record.disturbance_sd,
        record.disturbance_time_s,
    )
    geometry = Geometry(record.jaw, muscle_set, record.prior, record.knowledge, sds, upright, force)
    fill_settings(settings, geometry, noise, record.start_sd)
    return settings


def settings_of_configuration(configuration: Configuration, jaw: Any) -> Any:
    """Settings of an environment's filter, of dtype ``filter_settings_dtype``, for the geometry ``jaw``."""
    muscles, device = configuration.muscles, configuration.build_device()
    prior, knowledge = configuration.build_cohort().prior, configuration.build_knowledge()
    sensor = configuration.force_sensor
    motor_sds = sds_of_sensor(sensor, device)
    force = None if motor_sds is None else (motor_sds, device_with_sensor(sensor, device)[0])
    noise, spread = noise_of(device, sensor, TICK), start_sd(jaw)
    upright = _upright(jaw, configuration)
    sds = directions(knowledge, muscles, upright, prior.mean, motor_sds, with_memory=noise.disturbance_time_s > 0.0)
    disturbance = N_WRENCH if noise.disturbance_time_s > 0.0 else 0
    sizes = len(muscles), len(spread), len(muscles.muscle), len(sds), disturbance
    settings = record_zeros(1, filter_settings_dtype(*sizes))[0]
    settings["used"] = used_readings(configuration.sensors)
    fill_settings(settings, Geometry(jaw, muscles, prior, knowledge, sds, upright, force), noise, spread)
    return settings
