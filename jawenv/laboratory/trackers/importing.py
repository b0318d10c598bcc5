"""From a tracker's file and a force file to a recording, or to a file of another format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.anatomy.mandible import default_mandible
from jawenv.errors import InputError
from jawenv.laboratory.recordings.columns import ENCODERS, READINGS, TIME
from jawenv.laboratory.recordings.files import load_record
from jawenv.laboratory.recordings.mapping import mapped, read_columns
from jawenv.laboratory.recordings.plausibility import findings
from jawenv.laboratory.recordings.table import FORMATS, read_table, write_table
from jawenv.laboratory.recordings.words import WORDS
from jawenv.laboratory.trackers.bids_motion import MOTION, read_bids_motion, write_bids_motion
from jawenv.laboratory.trackers.clocks import clock_offset
from jawenv.laboratory.trackers.jaw_tracking_system import read_jaw_tracking_system
from jawenv.laboratory.trackers.markers import read_c3d, read_trc
from jawenv.laboratory.trackers.opensim import AXES as OPENSIM_AXES
from jawenv.laboratory.trackers.opensim import read_opensim, write_opensim
from jawenv.laboratory.trackers.registration import (
    FIXED,
    body_motion,
    check_travel,
    in_head_axes,
    names_of,
    read_landmarks,
    register,
    relative,
)
from jawenv.laboratory.trackers.tracks import Array, Tracks
from jawenv.reading import open_file

READERS: dict[str, Callable[[Path, str | None], Tracks]] = {
    ".c3d": read_c3d,
    ".trc": read_trc,
    ".mot": read_opensim,
    ".sto": read_opensim,
    ".h5": read_jaw_tracking_system,
    ".hdf5": read_jaw_tracking_system,
    ".tsv": read_bids_motion,
}
WRITERS: dict[str, Callable[[Tracks, Path], None]] = {
    ".mot": write_opensim,
    ".sto": write_opensim,
    ".tsv": write_bids_motion,
}
BODY = "jaw"


@dataclass(frozen=True)
class ImportSettings:
    """How a tracker's file is read.

    Attributes:
        forces: file with the load cell's columns; None where the tracker's file has them.
        landmarks: file with the three dental landmarks; None for a file that is in head axes already.
        registered: whether it is.
        jaw: names of a body, or of three or more markers on the lower jaw; None for the only body.
        head: the same on the head, or ``"fixed"``; None where the file is relative to the head.
        unit: of lengths, in place of what the file states.
        offset_s: what the force file's clock shows at 0 of the tracker's; None to find it.
        columns: mapping file for the force file, as ``load_record`` takes it.
    """

    forces: Path | None = None
    landmarks: Path | None = None
    registered: bool = False
    jaw: str | None = None
    head: str | None = None
    unit: str | None = None
    offset_s: float | None = None
    columns: Path | None = None


def import_file(path: Path, output: Path, settings: ImportSettings) -> list[str]:
    """Make a recording of a tracker's file, or write it as MOT, STO or BIDS-Motion.

    Args:
        path: .c3d, .trc, .mot, .sto, .h5, .hdf5, _motion.tsv, or a recording (.csv, .parquet).
        output: .csv or .parquet for a recording, .mot, .sto or _motion.tsv.
        settings: how it is read.

    Returns:
        Lines that state what was found: residuals and the clocks' offset.

    Raises:
        InputError: what cannot be read, registered, joined or written, or is no jaw's.
        MissingPackageError: h5py or ezc3d is not installed.
    """
    if output.suffix not in (*FORMATS, *WRITERS) or (output.suffix == ".tsv" and not output.name.endswith(MOTION)):
        raise InputError(f"{output}: the ending is {output.suffix!r}; allowed: .csv, .parquet, .mot, .sto, {MOTION}")
    with open_file(path):
        pass
    tracks, lines = _of_recording(path) if path.suffix in FORMATS else _of_tracker(path, settings)
    if settings.forces is not None:
        tracks, line = with_forces(tracks, settings.forces, settings)
        lines.append(line)
    if output.suffix in WRITERS:
        WRITERS[output.suffix](tracks, output)
    else:
        _write_recording(tracks, output)
    return [*lines, f"{output}: {len(tracks.time):,} rows"]


def _of_recording(path: Path) -> tuple[Tracks, list[str]]:
    record = load_record(path)
    readings = np.vstack([record.samples[:, 0], record.samples[-1:, 2]])
    seen = np.isfinite(record.measured[:, 3:6]).all(axis=1)
    turned = np.full((len(record.time), 3, 3), np.nan)
    turned[seen] = Rotation.from_euler("YZX", record.measured[seen, 3:6]).as_matrix()
    places = {BODY: 1e3 * record.measured[:, :3]}
    return Tracks(str(path), record.time, places, {BODY: turned}, {BODY: readings}, np.eye(3)), []


def _of_tracker(path: Path, settings: ImportSettings) -> tuple[Tracks, list[str]]:
    """The tracker's file with the body ``jaw`` in head axes, of the mouthpiece."""
    if path.suffix not in READERS:
        raise InputError(f"{path}: the ending is {path.suffix!r}; allowed: {', '.join((*READERS, *FORMATS))}")
    tracks = READERS[path.suffix](path, settings.unit)
    if (settings.landmarks is None) != settings.registered:
        allowed = "--landmarks FILE (incisor, molar_left, molar_right), or --registered for a file in head axes"
        raise InputError(f"{path}: axes are not stated; allowed: one of {allowed}")
    names = names_of(settings.jaw, tracks, "--jaw")
    if settings.landmarks is None:
        return _registered(tracks, names), []
    head = None
    if settings.head not in (None, FIXED):
        head = body_motion(tracks, names_of(settings.head, tracks, "--head"))
    elif settings.head is None and names[0] not in tracks.rotations:
        raise InputError(f"{path}: --head is missing; allowed: {FIXED}, or markers among {', '.join(tracks.places)}")
    motion = relative(body_motion(tracks, names), head)
    mandible = default_mandible()
    landmarks = read_landmarks(settings.landmarks, tracks)
    registration = register(landmarks, 1e3 * mandible.teeth_m, str(settings.landmarks))
    place, turned = in_head_axes(motion, registration, 1e3 * mandible.mouthpiece_m)
    lines = [f"landmarks: {registration.residual_mm:.2g} mm from the model's (root mean square)"]
    if motion.residual_mm > 0.0:
        lines.append(f"markers: {motion.residual_mm:.2g} mm from a rigid body (root mean square)")
    return replace(tracks, places={BODY: place}, rotations={BODY: turned}, wrenches={}), lines


def _registered(tracks: Tracks, names: list[str]) -> Tracks:
    """A file in head axes, turned to forward, left and up."""
    if tracks.axes is None:
        raise InputError(
            f"{tracks.path}: states no axes; allowed with --registered: MOT, STO, or BIDS with SpatialAxes"
        )
    if len(names) != 1 or names[0] not in tracks.rotations:
        raise InputError(f"{tracks.path}: --jaw is {', '.join(names)}; allowed with --registered: a body's name")
    place = tracks.places[names[0]] @ tracks.axes.T
    check_travel(place)
    turned = tracks.axes @ tracks.rotations[names[0]] @ tracks.axes.T
    wrenches = {BODY: _only_wrench(tracks, tracks.axes)} if tracks.wrenches else {}
    return replace(tracks, places={BODY: place}, rotations={BODY: turned}, wrenches=wrenches)


def _only_wrench(tracks: Tracks, axes: Array) -> Array:
    """(T, 6) of the file's only wrench, forward, left and up."""
    if len(tracks.wrenches) != 1:
        raise InputError(f"{tracks.path}: has {len(tracks.wrenches)} wrenches; allowed: one, of force and moment")
    (load,) = tracks.wrenches.values()
    return np.hstack([load[:, :3] @ axes.T, load[:, 3:] @ axes.T])


def with_forces(tracks: Tracks, path: Path, settings: ImportSettings) -> tuple[Tracks, str]:
    """The tracker's rows that a force file covers, with its forces read off between its rows.

    Returns:
        The tracks, and a line that states the offset of the clocks.

    Raises:
        InputError: a force file without one of its columns, or no offset.
    """
    columns = _force_columns(path, settings.columns)
    for name in (TIME, *(column.name for column in READINGS)):
        if name not in columns:
            raise InputError(f"{path}: column {name!r} is missing; allowed: docs/recordings.md, or --columns FILE")
    time = columns[TIME]
    if not (np.diff(time) > 0.0).all():
        raise InputError(f"{path}: {TIME} does not grow; allowed: growing numbers")
    if settings.offset_s is None:
        motion = encoder_columns(tracks)
        shared = next((name for name in motion if name in columns), None)
        if shared is None:
            allowed = f"one of {', '.join(motion)} in both files, or --offset SECONDS"
            raise InputError(
                f"{path}: no column shows the motion, so the clocks cannot be compared; allowed: {allowed}"
            )
        offset = clock_offset(tracks.time, motion[shared], time, columns[shared])
        seconds, sd_ms = offset.seconds, 1e3 * offset.sd_s
        line = f"clocks: {seconds:.4f} s give or take {sd_ms:.2g} ms ({shared}, correlation {offset.correlation:.3f})"
    else:
        seconds, line = settings.offset_s, f"clocks: {settings.offset_s:g} s, as given"
    at = tracks.time + seconds
    rows = (at >= time[0]) & (at <= time[-1])
    if rows.sum() < 2:
        raise InputError(
            f"{path}: shares {rows.sum()} rows with the tracker's file; allowed: two or more (the offset?)"
        )
    wrench = np.column_stack([np.interp(at[rows], time, columns[column.name]) for column in READINGS])
    return _rows(tracks, rows, wrench), line


def _rows(tracks: Tracks, rows: Array, wrench: Array) -> Tracks:
    places, turned = tracks.places[BODY][rows], tracks.rotations[BODY][rows]
    return replace(
        tracks, time=tracks.time[rows], places={BODY: places}, rotations={BODY: turned}, wrenches={BODY: wrench}
    )


def _force_columns(path: Path, mapping: Path | None) -> dict[str, Array]:
    """Columns of a recording, by name: of a CSV or Parquet file, or of the only wrench of a MOT or STO file."""
    if path.suffix in FORMATS:
        return mapped(read_table(path, WORDS), {} if mapping is None else read_columns(mapping)).columns
    if path.suffix not in (".mot", ".sto"):
        raise InputError(f"{path}: the ending is {path.suffix!r}; allowed: {', '.join((*FORMATS, '.mot', '.sto'))}")
    tracks = read_opensim(path, None)
    wrench = _only_wrench(tracks, OPENSIM_AXES)
    return {TIME: tracks.time} | {column.name: values for column, values in zip(READINGS, wrench.T, strict=True)}


def encoder_columns(tracks: Tracks) -> dict[str, Array]:
    """The columns of place (mm) and angles (deg) of a recording, by name; those that move most in opening first."""
    turned = tracks.rotations[BODY]
    seen = np.isfinite(turned).all(axis=(1, 2))
    angles = np.full((len(turned), 3), np.nan)
    angles[seen] = Rotation.from_matrix(turned[seen]).as_euler("YZX", degrees=True)
    x, y, z, pitch, yaw, roll = (column.name for column in ENCODERS[:6])
    places = tracks.places[BODY].T
    return {z: places[2], pitch: angles[:, 0], x: places[0], y: places[1], yaw: angles[:, 1], roll: angles[:, 2]}


def _write_recording(tracks: Tracks, output: Path) -> None:
    """Write a recording, unless its quantities are no jaw's on a device."""
    if BODY not in tracks.wrenches:
        raise InputError(f"{tracks.path}: has no forces; allowed: --forces FILE, or an output without them, as .mot")
    motion = encoder_columns(tracks)
    columns = {TIME: tracks.time - tracks.time[0]} | {column.name: motion[column.name] for column in ENCODERS[:6]}
    columns |= {column.name: values for column, values in zip(READINGS, tracks.wrenches[BODY].T, strict=True)}
    write_table(output, columns, {})
    try:
        bad = [finding for finding in findings(load_record(output)) if not finding.plausible]
    except InputError:
        output.unlink()
        raise
    if bad:
        output.unlink()
        raise InputError(f"{tracks.path}: {bad[0].columns}: {bad[0].value}; allowed: {bad[0].allowed}")
