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

from jawenv.anatomy import Prior, cohort
from jawenv.anatomy.knowledge import Knowledge
from jawenv.anatomy.knowledge import knowledge as knowledge_of
from jawenv.controls import Control
from jawenv.device.device import Device
from jawenv.device.force_sensor import ForceSensor
from jawenv.errors import InputError
from jawenv.files import Source
from jawenv.filter.model.joint_step import N_SAMPLES
from jawenv.laboratory.recordings import defaults
from jawenv.laboratory.recordings.checks import check_columns, even_time, has_any
from jawenv.laboratory.recordings.columns import ENCODERS, READINGS, SAMPLES, TIME, TRUE_WRENCH, Column, true_motion
from jawenv.laboratory.recordings.mapping import mapped, read_columns
from jawenv.laboratory.recordings.record import Record
from jawenv.laboratory.recordings.resampling import resampled
from jawenv.laboratory.recordings.table import RecordTable, checked_path, read_table, write_table
from jawenv.laboratory.recordings.words import WORDS, check_numbers, check_texts
from jawenv.ladder import model_named
from jawenv.mechanics.bilateral import N_BODY
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH

Array = NDArray[np.float64]
PathLike = str | os.PathLike[str]


def save_record(record: Record, path: PathLike) -> None:
    """Write a record so that ``load_record`` gives it back to rounding.

    Args:
        record: what a device has measured.
        path: ending in ``.csv`` or ``.parquet``; an existing file is replaced.

    Raises:
        InputError: another ending, Parquet without pyarrow, or a folder that cannot be written to.
    """
    target = checked_path(path)
    columns = {TIME: record.time}
    states = true_motion(len(record.start_mean))
    for column in (*ENCODERS, *SAMPLES, *(states if record.states is not None else ())):
        columns[column.name] = _written(record, column)
    if record.wrenches is not None:
        columns |= {column.name: _written(record, column) for column in TRUE_WRENCH}
    write_table(target, columns, _header(record))


def load_record(
    path: PathLike,
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
        path: a file as ``save_record`` writes it, or one's own with some of its columns (docs/recordings.md).
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

    Raises:
        InputError: a file, column, row or argument that cannot be used.
    """
    source = checked_path(path)
    table = mapped(read_table(source, WORDS), {} if columns is None else read_columns(Path(columns)))
    if resample_hz is not None:
        table = resampled(table, resample_hz)
    header = table.header
    check_texts(table)
    rung = model_named(model or header.get("model", "jaw"))
    muscles = rung.muscles
    states = N_BODY if rung.estimator == "bilateral" else N_STATES
    check_numbers(table, {"states": states, "parameters": len(muscles.parameter_names)})
    tilt = head_tilt_deg if head_tilt_deg is not None else header.get("head_tilt_deg", 0.0)
    jaw = _geometry(jaw, rung, tilt, header if model is None else {}, table.path)
    size = defaults.motion_size(jaw)
    time = even_time(table)
    check_columns(table, size)
    measured = _encoders(table)
    sensor = force_sensor or header.get("force_sensor", "cell")
    errors = _errors(device, header, sensor, float(time[1] - time[0]))
    measured_by = _device(device, header.get("device"), table.path)
    if measured_by is None and sensor != "cell":
        measured_by = Device()
    start = start_mean if start_mean is not None else header.get("start_mean")
    start_spread = start_sd if start_sd is not None else header.get("start_sd")
    if start is None:
        start = defaults.motion_of_reading(jaw, measured[0], errors["measurement_sd"])
    true_parameters = truth if truth is not None else header.get("truth")
    commanded = control or header.get("control", "force")
    return Record(
        time=time,
        measured=measured,
        samples=_samples(table, slack=sensor == "straps"),
        start_mean=np.array(start, dtype=np.float64),
        start_sd=np.array(defaults.start_sd(jaw) if start_spread is None else start_spread, dtype=np.float64),
        knowledge=_knowledge(knowledge, header.get("knowledge"), table.path),
        jaw=jaw,
        prior=_prior(prior, cohort, header, muscles, table.path),
        parameter_names=muscles.parameter_names,
        force_sensor=sensor,
        device=measured_by,
        control=commanded,
        truth=None if true_parameters is None else np.array(true_parameters, dtype=np.float64),
        states=_stacked(table, true_motion(size)),
        wrenches=_wrenches(table, TRUE_WRENCH) if TRUE_WRENCH[0].name in table.columns else None,
        **errors,
    )


def _errors(device: Device | None, header: dict[str, Any], sensor: ForceSensor, dt: float) -> dict[str, Any]:
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
    if not record.knowledge.exact:
        header["knowledge"] = {name: sd for name, sd in asdict(record.knowledge).items() if sd > 0.0}
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


def _geometry(jaw: Any | None, rung: Any, tilt: float, header: dict[str, Any], path: str) -> Any:
    """The geometry given, or the file's own, or the model's at that tilt of the head."""
    if jaw is None:
        stored = header.get("jaw")
        jaw = defaults.geometry(rung.name, tilt) if stored is None else _stored_jaw(stored, rung.name, path)
    lines = len(rung.muscles.muscle)
    if len(jaw["l_o"]) != lines:
        raise InputError(f"jaw has {len(jaw['l_o'])} lines; allowed with model {rung.name!r}: {lines}")
    return jaw


def _device(device: Device | None, fields: Any, path: str) -> Device | None:
    """The device given, or the file's own."""
    if device is not None or fields is None:
        return device
    try:
        return Device(**fields)
    except TypeError:
        raise InputError(f"{path}: device is {str(fields)[:40]!r}; allowed: fields of jawenv.Device") from None


def _knowledge(knowledge: str | Knowledge | Source | None, stored: Any, path: str) -> Knowledge:
    """The knowledge given, or the file's own."""
    if knowledge is not None or stored is None:
        return knowledge_of(knowledge)
    try:
        return knowledge_of(stored)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _prior(prior: Prior | None, name: str | None, header: dict[str, Any], muscles: Any, path: str) -> Prior:
    if prior is None and name is None and "prior_mean" in header and "prior_sd" in header:
        prior = Prior(header["prior_mean"], header["prior_sd"])
    if prior is None:
        return cohort(name or header.get("cohort", "trismus"), muscles).prior
    if len(prior.mean) != len(muscles.parameter_names):
        raise InputError(f"{path}: prior has {len(prior.mean)} parameters; allowed: {len(muscles.parameter_names)}")
    return prior


def _written(record: Record, column: Column) -> Array:
    """A column of T + 1 numbers; what belongs to a tick stands in the row in which the tick begins."""
    values = getattr(record, column.field)[(slice(None), *column.index)] * column.scale
    short = len(record.time) - len(values)
    return np.concatenate([values, np.full(short, np.nan)])


def _column(table: RecordTable, column: Column) -> Array:
    values = table.columns.get(column.name)
    return np.full(len(table.lines), np.nan) if values is None else values / column.scale


def _encoders(table: RecordTable) -> Array:
    """(T + 1, 12) readings, of which the first row has at least one."""
    measured = np.column_stack([_column(table, column) for column in ENCODERS])
    if not np.isfinite(measured[0]).any():
        allowed = ", ".join(column.name for column in ENCODERS)
        raise InputError(
            f"{table.path}: no encoder was read in row {table.lines[0]}; allowed: one or more of {allowed}"
        )
    return measured


def _stacked(table: RecordTable, columns: list[Column]) -> Array | None:
    if columns[0].name not in table.columns:
        return None
    return np.column_stack([_column(table, column) for column in columns])


def _wrenches(table: RecordTable, columns: tuple[Column, ...], slack: bool = False) -> Array:
    """(T, 3, 6) of three wrenches per tick; the last row begins no tick. Slack straps leave gaps."""
    ticks = len(table.lines) - 1
    wrenches: Array = np.empty((ticks, N_SAMPLES, N_WRENCH))
    for column in columns:
        values = _column(table, column)[:-1]
        if not slack:
            _complete(table, column, values)
        moment, component = column.index
        wrenches[:, moment, component] = values
    return wrenches


def _samples(table: RecordTable, slack: bool) -> Array:
    """(T, 3, 6) force at start, middle and end of each tick; the middle of single readings is interpolated."""
    if has_any(table, SAMPLES):
        return _wrenches(table, SAMPLES, slack)
    readings = np.column_stack([_column(table, column) for column in READINGS])
    for column, values in zip(READINGS, readings.T, strict=True):
        if not slack:
            _complete(table, column, values)
    return np.stack([readings[:-1], 0.5 * (readings[:-1] + readings[1:]), readings[1:]], axis=1)


def _complete(table: RecordTable, column: Column, values: Array) -> None:
    """A motion cannot be followed without the force that drives it."""
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise table.fail(column.name, int(bad[0]), "empty", "a reading of the load cell in every row")
