"""Settings of a recording: what the caller says by name, else the file's header, else a configuration."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jawenv.anatomy import Prior
from jawenv.base.errors import InputError
from jawenv.device.device import TICK
from jawenv.envs.configuration import Configuration, configure
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_SAMPLES
from jawenv.ladder import MODELS
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH
from jawenv.recordings import defaults
from jawenv.recordings.record import Record
from jawenv.recordings.words import OBJECTS, TEXTS

Header = dict[str, Any]


def resolved_world(configuration: Configuration, settings: dict[str, Any], header: Header, path: str) -> Configuration:
    """The configuration with what the file says in its place, and with the caller's settings in the place of both."""
    rate: dict[str, Any] = {"control_hz": None}  # the control mode's own: a record has no control steps
    words = {*TEXTS, *OBJECTS} - {"jaw", *settings}
    model = settings.get("model", header.get("model", configuration.model))
    if isinstance(model, str) and model in MODELS and MODELS[model].plant != "midline":  # of known anatomy
        configuration = replace(configuration, knowledge="exact")
    try:
        world = configure(rate | {word: header[word] for word in words if word in header}, base=configuration)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return configure(rate | settings, base=world)


def resolved_errors(world: Configuration, header: Header, dt: float) -> dict[str, Any]:
    """A record's sds and the disturbance: the header's, or else those of the world's device."""
    noise, sensor = world.build_device(), world.force_sensor
    time_constant = float(header.get("disturbance_time_s", noise.unmodelled_time_s))
    remembered = defaults.disturbance_sd(noise) if time_constant > 0.0 else np.zeros(N_WRENCH)
    return {
        "measurement_sd": np.array(header.get("measurement_sd", defaults.measurement_sd(noise))),
        "wrench_sd": np.array(header.get("wrench_sd", defaults.wrench_sd(noise, dt, sensor))),
        "cell_sd": np.array(header.get("cell_sd", defaults.cell_sd(noise, sensor))),
        "gain_sd": float(header.get("gain_sd", noise.cell_gain if sensor == "cell" else 0.0)),
        "disturbance_time_s": time_constant,
        "disturbance_sd": np.array(header.get("disturbance_sd", remembered)),
    }


def _stored_jaw(stored: dict[str, Any], like: Any, path: str) -> Any:
    jaw = like.copy()
    try:
        for name in jaw.dtype.names:
            jaw[name] = stored[name]
            if not np.isfinite(jaw[name]).all():
                raise ValueError("infinite or not a number")
    except (KeyError, TypeError, ValueError, OverflowError):
        raise InputError(
            f"{path}: jaw lacks {name!r}, or has it in another shape or not finite; allowed: as save_record wrote it"
        ) from None
    return jaw


def resolved_geometry(jaw: Any | None, world: Configuration, tilt: float, header: Header, path: str) -> Any:
    """The geometry given, or the file's own, or the world's at that tilt of the head."""
    own = defaults.geometry_of(world, tilt)
    if jaw is None:
        jaw = own if "jaw" not in header else _stored_jaw(header["jaw"], own, path)
    if len(jaw["l_o"]) != len(own["l_o"]):
        raise InputError(f"jaw has {len(jaw['l_o'])} lines; allowed with model {world.model!r}: {len(own['l_o'])}")
    return jaw


def resolved_prior(world: Configuration, header: Header) -> Prior:
    """The prior in the header, or else that of the world's cohort."""
    if "prior_mean" in header and "prior_sd" in header:
        return Prior(header["prior_mean"], header["prior_sd"])
    return world.build_cohort().prior


def unread(world: Configuration, jaw: Any) -> Record:
    """A record of a world's device, patient and knowledge in which nothing is read."""
    return Record(
        time=TICK * np.arange(2, dtype=np.float64),
        measured=np.full((2, N_MEASUREMENTS), np.nan),
        samples=np.full((1, N_SAMPLES, N_WRENCH), np.nan),
        start_mean=np.zeros(N_STATES),
        start_sd=defaults.start_sd(jaw),
        jaw=jaw.copy(),
        prior=world.build_cohort().prior,
        parameter_names=world.muscles.parameter_names,
        knowledge=world.build_knowledge(),
        force_sensor=world.force_sensor,
        device=world.build_device(),
        **resolved_errors(world, {}, TICK),
    )
