"""Recordings as files, CSV or Parquet: of a simulated device or of a test bench.

One row per time, one column per quantity with its unit in the name (``columns``; docs/recordings.md). Lines
``# name: value`` before the header row (CSV), or the file's metadata (Parquet), hold what is not a time series: noise,
geometry, prior, truth. All of it may be missing: what ``load_record`` is told by name comes before the file, the file
before a configuration.
"""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.envs.configuration import Configuration
from jawenv.mechanics.dynamics import N_STATES
from jawenv.recordings import defaults
from jawenv.recordings.checks import check_columns, even_time
from jawenv.recordings.columns import ENCODERS, SAMPLES, TIME, TRUE_MOTION, TRUE_WRENCH
from jawenv.recordings.mapping import mapped, read_columns
from jawenv.recordings.record import Record
from jawenv.recordings.resampling import resampled
from jawenv.recordings.resolved import resolved_errors, resolved_geometry, resolved_prior, resolved_world
from jawenv.recordings.series import begun, encoders, line_variance, samples, stacked, wrenches, written
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
    for column in (*ENCODERS, *SAMPLES, *(TRUE_MOTION if record.states is not None else ())):
        columns[column.name] = written(record, column)
    if record.wrenches is not None:
        columns |= {column.name: written(record, column) for column in TRUE_WRENCH}
    write_table(target, columns, _header(record))


def load_record(
    path: PathLike | RecordTable,
    configuration: Configuration | None = None,
    *,
    head_tilt_deg: float | None = None,
    jaw: Any | None = None,
    columns: PathLike | None = None,
    resample_hz: float | None = None,
    **settings: Any,
) -> Record:
    """Read a recording.

    Args:
        path: a file as ``save_record`` writes it, or one's own with some of its columns (docs/recordings.md); or the
            table that such a file would hold.
        configuration: what neither the settings nor the file says: model, cohort, device, knowledge, force sensor,
            anatomy, control. Without it those of the default environment in force control, and the cohort anyone.
        head_tilt_deg: pitch of the head, positive looking down; the file's, or 0.
        jaw: a geometry of one's own with the model's muscles, from ``jawenv.mechanics.build_jaw``.
        columns: mapping file with the names, units and signs that the file has for the columns of docs/recordings.md.
        resample_hz: rows per second to which uneven times are interpolated.
        **settings: arguments of the environments by name, which come before the file; None says nothing.
    """
    settings = {name: value for name, value in settings.items() if value is not None}
    given = path if isinstance(path, RecordTable) else read_table(checked_path(path), WORDS)
    table = mapped(given, {} if columns is None else read_columns(Path(columns)))
    if resample_hz is not None:
        table = resampled(table, resample_hz)
    table = begun(table)
    check_texts(table)
    header = {word: value for word, value in table.header.items() if _OVERRULED.get(word) not in settings}
    world = resolved_world(configuration or defaults.UNLABELLED, settings, header, table.path)
    names, sensor = world.muscles.parameter_names, world.force_sensor
    check_numbers(table, {"states": N_STATES, "parameters": len(names)})
    tilt = header.get("head_tilt_deg", 0.0) if head_tilt_deg is None else head_tilt_deg
    jaw = resolved_geometry(jaw, world, tilt, header, table.path)
    time = even_time(table)
    check_columns(table)
    measured = encoders(table)
    errors = resolved_errors(world, header, float(time[1] - time[0]))
    errors["wrench_sd"] = np.sqrt(errors["wrench_sd"] ** 2 + line_variance(table, errors["cell_sd"]))
    start, truth = header.get("start_mean"), header.get("truth")
    if start is None:
        start = defaults.motion_of_reading(jaw, measured[0], errors["measurement_sd"])
    is_of_a_device = configuration is not None or sensor != "cell" or "device" in header | settings
    return Record(
        time=time,
        measured=measured,
        samples=samples(table, slack=sensor == "straps"),
        start_mean=np.array(start, dtype=np.float64),
        start_sd=np.array(header.get("start_sd", defaults.start_sd(jaw)), dtype=np.float64),
        knowledge=world.build_knowledge(),
        jaw=jaw,
        prior=resolved_prior(world, header),
        parameter_names=names,
        force_sensor=sensor,
        device=world.build_device() if is_of_a_device else None,
        control=world.control,
        truth=None if truth is None else np.array(truth, dtype=np.float64),
        states=stacked(table, TRUE_MOTION),
        wrenches=wrenches(table, TRUE_WRENCH) if TRUE_WRENCH[0].name in table.columns else None,
        **errors,
    )


_OF_A_DEVICE = ("measurement_sd", "wrench_sd", "cell_sd", "gain_sd", "disturbance_time_s", "disturbance_sd")
_OVERRULED = {
    **dict.fromkeys(_OF_A_DEVICE, "device"),
    **dict.fromkeys(("prior_mean", "prior_sd"), "cohort"),
    "jaw": "model",
}
"""Words of the header -> the setting that says anew what they say."""


def _header(record: Record) -> dict[str, Any]:
    """The file's header, SI units, all arrays as lists."""
    match = defaults.model_of_geometry(record.jaw)
    names = [model.name for model in defaults.matching_models(record.parameter_names)]
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
