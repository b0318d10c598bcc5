"""Recordings as files, CSV or Parquet: of a simulated device or of a test bench.

One row per time, one column per quantity with its unit in the name (``columns``; docs/recordings.md). Lines
``# name: value`` before the header row (CSV), or the file's metadata (Parquet), hold what is not a time series: noise,
geometry, prior, truth. All of it may be missing; arguments of ``load_record`` come before the file, the file before
the defaults.
"""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Prior
from jawenv.anatomy.knowledge import Knowledge
from jawenv.base.errors import InputError
from jawenv.base.files import Source
from jawenv.controls import Control
from jawenv.device.device import Device
from jawenv.device.force_sensor import ForceSensor
from jawenv.ladder import model_named
from jawenv.mechanics.bilateral import N_BODY
from jawenv.mechanics.dynamics import N_STATES
from jawenv.recordings import defaults
from jawenv.recordings.checks import check_columns, even_time
from jawenv.recordings.columns import ENCODERS, SAMPLES, TIME, TRUE_WRENCH, true_motion
from jawenv.recordings.given import (
    given_device,
    given_errors,
    given_geometry,
    given_knowledge,
    given_prior,
)
from jawenv.recordings.mapping import mapped, read_columns
from jawenv.recordings.record import Record
from jawenv.recordings.resampling import resampled
from jawenv.recordings.series import encoders, samples, stacked, wrenches, written
from jawenv.recordings.table import RecordTable, checked_path, read_table, write_table
from jawenv.recordings.words import WORDS, check_numbers, check_texts

Array = NDArray[np.float64]
PathLike = str | os.PathLike[str]


def save_record(record: Record, path: PathLike) -> None:
    """Write a record so that ``load_record`` gives it back to rounding.

    Args:
        record: what a device has measured.
        path: ending in ``.csv`` or ``.parquet``; an existing file is replaced.
    """
    target = checked_path(path)
    columns = {TIME: record.time}
    states = true_motion(len(record.start_mean))
    for column in (*ENCODERS, *SAMPLES, *(states if record.states is not None else ())):
        columns[column.name] = written(record, column)
    if record.wrenches is not None:
        columns |= {column.name: written(record, column) for column in TRUE_WRENCH}
    write_table(target, columns, _header(record))


def load_record(
    path: PathLike | RecordTable,
    *,
    model: str | None = None,
    head_tilt_deg: float | None = None,
    jaw: Any | None = None,
    cohort: str | None = None,
    prior: Prior | None = None,
    knowledge: str | Knowledge | Source | None = None,
    force_sensor: ForceSensor | None = None,
    device: Device | None = None,
    start_mean: Array | None = None,
    start_sd: Array | None = None,
    control: Control | None = None,
    truth: Array | None = None,
    columns: PathLike | None = None,
    resample_hz: float | None = None,
) -> Record:
    """Read a recording. What neither the arguments nor the file says has the default named here.

    Args:
        path: a file as ``save_record`` writes it, or one's own with some of its columns (docs/recordings.md); or the
            table that such a file would hold.
        model: rung of the ladder whose geometry and muscles the estimator believes in; ``"jaw"``.
        head_tilt_deg: pitch of the head, positive looking down; 0.
        jaw: a geometry of one's own with that model's muscles, from ``jawenv.mechanics.build_jaw``.
        cohort: population whose prior is the belief before the record; ``"trismus"``.
        prior: a belief of one's own, in natural logs.
        knowledge: within which sds geometry, mass and mounting are known, as the environments take it; ``"exact"``.
        force_sensor: how the device knew its force, as the environments take it; ``"cell"``.
        device: that measured, with its noise of encoders and load cell; the noise of ``jawenv.Device()``.
        start_mean: (n,) motion (q, u) believed before the first reading; what explains the first reading best.
        start_sd: (n,) its sd; so wide that the first reading decides.
        control: what the motors were commanded; ``"force"``.
        truth: (p,) natural-log parameters, if known; None.
        columns: mapping file with the names, units and signs that the file has for the columns of docs/recordings.md.
        resample_hz: rows per second to which uneven times are interpolated.
    """
    given = path if isinstance(path, RecordTable) else read_table(checked_path(path), WORDS)
    table = mapped(given, {} if columns is None else read_columns(Path(columns)))
    if resample_hz is not None:
        table = resampled(table, resample_hz)
    header = table.header
    check_texts(table)

    def either(argument: Any, name: str, default: Any = None) -> Any:
        return header.get(name, default) if argument is None else argument

    rung = model_named(either(model, "model", "jaw"))
    names = rung.muscles.parameter_names
    check_numbers(table, {"states": N_BODY if rung.estimator == "bilateral" else N_STATES, "parameters": len(names)})
    tilt = either(head_tilt_deg, "head_tilt_deg", 0.0)
    jaw = given_geometry(jaw, rung, tilt, header if model is None else {}, table.path)
    size = defaults.motion_size(jaw)
    time = even_time(table)
    check_columns(table, size)
    measured = encoders(table)
    sensor = either(force_sensor, "force_sensor", "cell")
    errors = given_errors(device, header, sensor, float(time[1] - time[0]))
    measured_by = given_device(device, header.get("device"), table.path)
    start, spread = either(start_mean, "start_mean"), either(start_sd, "start_sd")
    if start is None:
        start = defaults.motion_of_reading(jaw, measured[0], errors["measurement_sd"])
    known = either(truth, "truth")
    return Record(
        time=time,
        measured=measured,
        samples=samples(table, slack=sensor == "straps"),
        start_mean=np.array(start, dtype=np.float64),
        start_sd=np.array(defaults.start_sd(jaw) if spread is None else spread, dtype=np.float64),
        knowledge=given_knowledge(knowledge, header.get("knowledge"), table.path),
        jaw=jaw,
        prior=given_prior(prior, cohort, header, rung.muscles, table.path),
        parameter_names=names,
        force_sensor=sensor,
        device=Device() if measured_by is None and sensor != "cell" else measured_by,
        control=either(control, "control", "force"),
        truth=None if known is None else np.array(known, dtype=np.float64),
        states=stacked(table, true_motion(size)),
        wrenches=wrenches(table, TRUE_WRENCH) if TRUE_WRENCH[0].name in table.columns else None,
        **errors,
    )


def _header(record: Record) -> dict[str, Any]:
    """The file's header, SI units, all arrays as lists."""
    match = defaults.model_of_geometry(record.jaw)
    names = [model.name for model in defaults.matching_models(record.parameter_names, len(record.start_mean))]
    header: dict[str, Any] = {}
    if match is not None and match[0] in names:
        header["model"], header["head_tilt_deg"] = match
    elif names:
        header["model"] = names[0]
        header["jaw"] = {name: np.asarray(record.jaw[name]).tolist() for name in record.jaw.dtype.names}
    else:
        raise InputError(
            f"record: parameter_names are {record.parameter_names}; allowed: those of a model of the ladder"
        )
    header |= {"prior_mean": record.prior.mean.tolist(), "prior_sd": record.prior.sd.tolist()}
    header |= {
        name: getattr(record, name).tolist()
        for name in ("measurement_sd", "wrench_sd", "cell_sd", "start_mean", "start_sd")
    }
    header["gain_sd"] = record.gain_sd
    known = {name: sd for name, sd in asdict(record.knowledge).items() if sd > 0.0}
    header["knowledge"] = known or "exact"
    if record.disturbance_time_s > 0.0:
        header["disturbance_time_s"] = record.disturbance_time_s
        header["disturbance_sd"] = record.disturbance_sd.tolist()
    if record.force_sensor != "cell":
        header["force_sensor"] = record.force_sensor
    header["control"] = record.control
    if record.device is not None:
        header["device"] = asdict(record.device)
    if record.truth is not None:
        header["truth"] = record.truth.tolist()
    return header
