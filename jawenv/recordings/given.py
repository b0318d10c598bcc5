"""Settings of a recording: what an argument gives, else the file's header, else the default."""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.anatomy import Prior, cohort
from jawenv.anatomy.knowledge import Knowledge
from jawenv.anatomy.knowledge import knowledge as knowledge_of
from jawenv.base.errors import InputError
from jawenv.base.files import Source
from jawenv.device.device import Device
from jawenv.device.force_sensor import ForceSensor
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings import defaults


def given_errors(device: Device | None, header: dict[str, Any], sensor: ForceSensor, dt: float) -> dict[str, Any]:
    """A record's sds and the disturbance: of the device given, or the file's own, or the default device's."""
    noise, stored = device or Device(), header if device is None else {}
    time_constant = float(stored.get("disturbance_time_s", noise.unmodelled_time_s))
    remembered = defaults.disturbance_sd(noise) if time_constant > 0.0 else np.zeros(N_WRENCH)
    return {
        "measurement_sd": np.array(stored.get("measurement_sd", defaults.measurement_sd(noise))),
        "wrench_sd": np.array(stored.get("wrench_sd", defaults.wrench_sd(noise, dt, sensor))),
        "cell_sd": np.array(stored.get("cell_sd", defaults.cell_sd(noise, sensor))),
        "gain_sd": float(stored.get("gain_sd", noise.cell_gain if sensor == "cell" else 0.0)),
        "disturbance_time_s": time_constant,
        "disturbance_sd": np.array(stored.get("disturbance_sd", remembered)),
    }


def _stored_jaw(fields: dict[str, Any], model: str, path: str) -> Any:
    jaw = defaults.geometry(model)
    try:
        for name in jaw.dtype.names:
            jaw[name] = fields[name]
            if not np.isfinite(jaw[name]).all():
                raise ValueError("infinite or not a number")
    except (KeyError, TypeError, ValueError, OverflowError):
        raise InputError(
            f"{path}: jaw lacks {name!r}, or has it in another shape or not finite; allowed: as save_record wrote it"
        ) from None
    return jaw


def given_geometry(jaw: Any | None, rung: Any, tilt: float, header: dict[str, Any], path: str) -> Any:
    """The geometry given, or the file's own, or the model's at that tilt of the head."""
    if jaw is None:
        stored = header.get("jaw")
        jaw = defaults.geometry(rung.name, tilt) if stored is None else _stored_jaw(stored, rung.name, path)
    lines = len(rung.muscles.muscle)
    if len(jaw["l_o"]) != lines:
        raise InputError(f"jaw has {len(jaw['l_o'])} lines; allowed with model {rung.name!r}: {lines}")
    return jaw


def given_device(device: Device | None, fields: Any, path: str) -> Device | None:
    """The device given, or the file's own."""
    if device is not None or fields is None:
        return device
    try:
        return Device(**fields)
    except TypeError:
        raise InputError(f"{path}: device is {str(fields)[:40]!r}; allowed: fields of jawenv.Device") from None


def given_knowledge(knowledge: str | Knowledge | Source | None, stored: Any, path: str) -> Knowledge:
    """The knowledge given, or the file's own."""
    if knowledge is not None or stored is None:
        return knowledge_of(knowledge)
    try:
        return knowledge_of(stored)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def given_prior(prior: Prior | None, name: str | None, header: dict[str, Any], muscles: Any, path: str) -> Prior:
    """The prior given, or that of the cohort given, or the file's own."""
    if prior is None and name is None and "prior_mean" in header and "prior_sd" in header:
        prior = Prior(header["prior_mean"], header["prior_sd"])
    if prior is None:
        return cohort(name or header.get("cohort", "trismus"), muscles).prior
    if len(prior.mean) != len(muscles.parameter_names):
        raise InputError(f"{path}: prior has {len(prior.mean)} parameters; allowed: {len(muscles.parameter_names)}")
    return prior
