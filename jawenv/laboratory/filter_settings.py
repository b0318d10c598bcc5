"""Settings of the environments' filter for a geometry that is known within sds, and for a record."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.knowledge import Knowledge
from jawenv.device.force_sensor import sds_of_sensor
from jawenv.filter import least_noise
from jawenv.filter.nuisances.known_within import write_nuisances
from jawenv.filter.readings.screening import rough_change
from jawenv.filter.tick import filter_settings_dtype, set_prior
from jawenv.kernels.records import record_zeros
from jawenv.laboratory.recordings import defaults
from jawenv.laboratory.recordings.record import Record
from jawenv.ladder import Model
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.unknowns import Unknowns, directions

_OF_THE_BODY = ("mass", "centre_of_mass", "inertia", "inertia_inverse", "inertia_contact_inverse", "gravity")


def sds_of(
    jaw: Any, model: Model, knowledge: Knowledge, prior: Any, motor_sds: NDArray[np.float64] | None = None
) -> tuple[Any, list[Unknowns]]:
    """The geometry about which sds are taken, and one sd of every nuisance that the filter integrates out.

    Sds of mass, inertia and gravity are those of the default mandible with the head upright, as an environment has
    them.

    Args:
        jaw: geometry of the patient.
        model: rung of the ladder.
        knowledge: the sds.
        prior: of the parameters.
        motor_sds: those of a force that no load cell reads, or None.
    """
    upright, default = jaw.copy(), defaults.geometry(model.name)
    for name in _OF_THE_BODY:
        upright[name] = default[name]
    return upright, directions(knowledge, model.muscles, upright, prior.mean, motor_sds)


def settings_of_record(record: Record) -> Any:
    """A record's noise, prior, nuisances and disturbance, of dtype ``filter_settings_dtype``."""
    states, muscles = len(record.start_mean), len(record.parameter_names) // 2
    sds: list[Unknowns] = []
    force = None
    if record.force_sensor != "cell" and record.device is not None:
        motor_sds = sds_of_sensor(record.force_sensor, record.device)
        assert motor_sds is not None, "no load cell reads the force"
        force = motor_sds, record.device.records()[0]
    if not record.knowledge.exact or force is not None:
        model = defaults.matching_models(record.parameter_names, states)[0]
        known = record.jaw, model, record.knowledge, record.prior
        upright, sds = sds_of(*known, None if force is None else force[0])
    lines = len(record.jaw["l_o"]) if sds else 1
    disturbance = N_WRENCH if record.disturbance_time_s > 0.0 else 0
    settings = record_zeros(1, filter_settings_dtype(muscles, states, lines, len(sds), disturbance))[0]
    settings["dt"], settings["gain_variance"] = record.dt, record.gain_sd**2
    settings["measurement_variance"] = record.measurement_sd**2
    settings["wrench_variance"] = record.noise_variance[:N_WRENCH]
    settings["used"], settings["start_sd"][:states] = True, record.start_sd
    settings["cell_repeats"] = least_noise.cell_repeats(record.cell_sd)
    settings["rough"] = rough_change(record.cell_sd, record.dt)
    set_prior(settings, record.jaw, record.prior)
    if sds:
        write_nuisances(settings["nuisances"], upright, record.knowledge, model.muscles, sds, force)
    if disturbance:
        variance, time = record.disturbance_sd**2, record.disturbance_time_s
        settings["start_sd"][states:] = record.disturbance_sd
        settings["disturbance_decay"] = np.exp(-record.dt / time)
        settings["disturbance_variance"] = variance * -np.expm1(-2.0 * record.dt / time)
    return settings
