"""Conversion of a tracker's file and a force file to a recording, or to a file of another format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.anatomy.mandible import default_mandible
from jawenv.base.errors import InputError
from jawenv.base.files import check_kept
from jawenv.base.reading import open_file
from jawenv.recordings.columns import ENCODERS, READINGS, TIME
from jawenv.recordings.files import load_record
from jawenv.recordings.plausibility import findings
from jawenv.recordings.resampling import resampled
from jawenv.recordings.table import FORMATS, RecordTable, write_table
from jawenv.trackers.c3d import read_c3d
from jawenv.trackers.forces import at_mouthpiece, only_wrench, with_analog_forces, with_force_file
from jawenv.trackers.jaw_tracking_system import read_jaw_tracking_system
from jawenv.trackers.motion import BODY, encoder_columns
from jawenv.trackers.opensim import read_opensim, write_opensim
from jawenv.trackers.registration import (
    FIXED,
    SMOOTHED,
    body_motion,
    check_travel,
    in_head_axes,
    names_of,
    read_landmarks,
    register,
    relative,
)
from jawenv.trackers.tracks import Tracks, listed
from jawenv.trackers.trc import read_trc

READERS: dict[str, Callable[[Path, str | None], Tracks]] = {
    ".c3d": read_c3d,
    ".trc": read_trc,
    ".mot": read_opensim,
    ".sto": read_opensim,
    ".h5": read_jaw_tracking_system,
    ".hdf5": read_jaw_tracking_system,
}
WRITERS: dict[str, Callable[[Tracks, Path], None]] = {
    ".mot": write_opensim,
    ".sto": write_opensim,
}


@dataclass(frozen=True)
class ImportSettings:
    """Settings for reading a tracker's file."""

    forces: Path | None = None  # file with the load cell's columns; None where the tracker's file has them
    landmarks: Path | None = None  # file with the three dental landmarks; None for a file that is in head axes already
    registered: bool = False  # whether it is
    jaw: str | None = None  # names of a body, or of three or more markers on the lower jaw; None for the only body
    head: str | None = None  # the same on the head, or ``"fixed"``; None where the file is relative to the head
    unit: str | None = None  # of lengths, in place of what the file states
    offset_s: float | None = None  # what the force file's clock shows at 0 of the tracker's; None to find it
    columns: Path | None = None  # mapping file for the forces, or for a recording, as ``load_record`` takes it
    resample_hz: float | None = None  # rows per second of a recording, to which uneven times are interpolated


def import_file(path: Path, output: Path, settings: ImportSettings) -> list[str]:
    """Make a recording of a tracker's file, or write it as MOT or STO.

    Args:
        path: .c3d, .trc, .mot, .sto, .h5, .hdf5, or a recording (.csv, .parquet).
        output: .csv or .parquet for a recording, .mot or .sto.
        settings: how it is read.

    Returns:
        Lines that state what was found: residuals and the clocks' offset.

    Raises:
        InputError: what cannot be read, registered, joined or written, or is no jaw's.
        MissingPackageError: h5py or ezc3d is not installed.
    """
    if output.suffix not in (*FORMATS, *WRITERS):
        raise InputError(f"{output}: the ending is {output.suffix!r}; allowed: {', '.join((*FORMATS, *WRITERS))}")
    check_kept(output, [path, settings.forces, settings.landmarks, settings.columns])
    if settings.resample_hz is not None and {path.suffix, output.suffix}.isdisjoint(FORMATS):
        raise InputError(f"--resample is given with {output}; allowed: from or to a recording, {' or '.join(FORMATS)}")
    with open_file(path):
        pass
    tracks, lines = _of_recording(path, settings) if path.suffix in FORMATS else _of_tracker(path, settings)
    if settings.forces is not None:
        tracks, line = with_force_file(tracks, settings.forces, settings.columns, settings.offset_s)
        lines.append(line)
    elif tracks.analog is not None and (output.suffix in FORMATS or settings.columns is not None):
        tracks, line = with_analog_forces(tracks, settings.columns)
        lines.append(line)
    if output.suffix in WRITERS:
        WRITERS[output.suffix](tracks, output)
        return [*lines, f"{output}: {len(tracks.time):,} rows"]
    table = _judged(tracks, settings.resample_hz)
    write_table(output, table.columns, {})
    return [*lines, f"{output}: {len(table.lines):,} rows"]


def _of_recording(path: Path, settings: ImportSettings) -> tuple[Tracks, list[str]]:
    own = settings.columns if settings.forces is None else None
    record = load_record(path, columns=own, resample_hz=settings.resample_hz)
    readings = np.vstack([record.samples[:, 0], record.samples[-1:, 2]])
    seen = np.isfinite(record.measured[:, 3:6]).all(axis=1)
    turned = np.full((len(record.time), 3, 3), np.nan)
    turned[seen] = Rotation.from_euler("YZX", record.measured[seen, 3:6]).as_matrix()
    return Tracks(str(path), record.time, {BODY: 1e3 * record.measured[:, :3]}, {BODY: turned}, {BODY: readings}), []


def _of_tracker(path: Path, settings: ImportSettings) -> tuple[Tracks, list[str]]:
    """The tracker's file with the body ``jaw`` in head axes, of the mouthpiece."""
    if path.suffix not in READERS:
        raise InputError(f"{path}: the ending is {path.suffix!r}; allowed: {', '.join((*READERS, *FORMATS))}")
    tracks = READERS[path.suffix](path, settings.unit)
    if (settings.landmarks is None) != settings.registered:
        allowed = "--landmarks FILE (incisor, molar_left, molar_right), or --registered for a file in head axes"
        raise InputError(f"{path}: axes are not stated; allowed: one of {allowed}")
    names = names_of(settings.jaw, tracks, "--jaw")
    lines = [f"jaw: {name} is smoothed, so error bars will be too small" for name in names if name.endswith(SMOOTHED)]
    if settings.landmarks is None:
        return _registered(tracks, names), lines
    axes = tracks.axes.get(names[0], np.eye(3))
    tracks = tracks.turned(names[0])
    head = None
    if settings.head not in (None, FIXED):
        head = body_motion(tracks, names_of(settings.head, tracks, "--head"))
    elif settings.head is None and names[0] not in tracks.rotations:
        raise InputError(f"{path}: --head is missing; allowed: {FIXED}, or markers among {listed(tracks.places)}")
    motion = relative(body_motion(tracks, names), head)
    mandible = default_mandible()
    landmarks = read_landmarks(settings.landmarks, tracks, axes)
    registration = register(landmarks, 1e3 * mandible.teeth_m, str(settings.landmarks))
    place, turned = in_head_axes(motion, registration, 1e3 * mandible.mouthpiece_m)
    lines.append(f"landmarks: {registration.residual_mm:.2g} mm from the model's (root mean square)")
    if motion.residual_mm > 0.0:
        how = f"{motion.residual_mm:.2g} mm from a rigid body (root mean square), {motion.worst_mm:.2g} at worst"
        lines.append(f"markers: {how}")
    return replace(tracks, places={BODY: place}, rotations={BODY: turned}, wrenches={}), lines


def _registered(tracks: Tracks, names: list[str]) -> Tracks:
    """A file in head axes, turned to forward, left and up."""
    if len(names) != 1 or names[0] not in tracks.rotations:
        bodies = listed(tracks.rotations) or "none is in the file"
        raise InputError(
            f"{tracks.path}: --jaw is {listed(names)}; allowed with --registered: a body with angles ({bodies})"
        )
    if names[0] not in tracks.axes:
        raise InputError(f"{tracks.path}: states no axes; allowed with --registered: MOT or STO")
    turned = tracks.turned(names[0])
    place, rotations = turned.places[names[0]], turned.rotations[names[0]]
    check_travel(place)
    wrenches = {}
    if tracks.wrenches:
        wrench, point = only_wrench(tracks)
        wrenches = {BODY: wrench if point is None else at_mouthpiece(wrench, point, place, rotations)}
    return replace(tracks, places={BODY: place}, rotations={BODY: rotations}, wrenches=wrenches)


def _judged(tracks: Tracks, hz: float | None) -> RecordTable:
    """A recording's columns, unless its quantities are no jaw's on a device."""
    if BODY not in tracks.wrenches:
        raise InputError(f"{tracks.path}: has no forces; allowed: --forces FILE, or an output without them, as .mot")
    motion = encoder_columns(tracks)
    columns = {TIME: tracks.time - tracks.time[0]} | {column.name: motion[column.name] for column in ENCODERS[:6]}
    columns |= {column.name: values for column, values in zip(READINGS, tracks.wrenches[BODY].T, strict=True)}
    table = RecordTable(tracks.path, columns, np.arange(1, len(tracks.time) + 1), {})
    if hz is not None:
        table = resampled(table, hz)
    bad = [finding for finding in findings(load_record(table)) if not finding.plausible and finding.spoils]
    if bad:
        raise InputError(f"{tracks.path}: {bad[0].columns}: {bad[0].value}; allowed: {bad[0].allowed}")
    return table
