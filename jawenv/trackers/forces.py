"""Forces for a tracker's motion: of a load cell's file on a clock of its own, or of channels in the tracker's file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from jawenv.base.errors import InputError
from jawenv.recordings.columns import READINGS, TIME
from jawenv.recordings.mapping import mapped, read_columns
from jawenv.recordings.table import FORMATS, read_table
from jawenv.recordings.words import WORDS
from jawenv.trackers.clocks import clock_offset
from jawenv.trackers.motion import BODY, encoder_columns
from jawenv.trackers.opensim import read_opensim
from jawenv.trackers.tracks import Array, Tracks, listed

POINT = ("point_x_mm", "point_y_mm", "point_z_mm")
"""Columns of where a force acts, head axes."""
LONGEST_GAP = 2.5
"""Usual steps between two readings; over a longer gap nothing was read."""


def with_force_file(tracks: Tracks, path: Path, mapping: Path | None, offset_s: float | None) -> tuple[Tracks, str]:
    """The tracker's rows that a force file covers, with its forces read off between its rows.

    Args:
        tracks: with the body ``jaw`` in head axes.
        path: of the force file.
        mapping: file with its names, units and signs.
        offset_s: what its clock shows at 0 of the tracker's; None to find it.

    Returns:
        The tracks, and a line that states the offset of the clocks.
    """
    columns = _force_columns(path, mapping)
    for name in (TIME, *(column.name for column in READINGS)):
        if name not in columns:
            raise InputError(f"{path}: column {name!r} is missing; allowed: docs/recordings.md, or --columns FILE")
    time = columns[TIME]
    if len(time) < 2 or not (np.diff(time) > 0.0).all():
        raise InputError(f"{path}: {TIME} does not grow; allowed: two or more growing numbers")
    if offset_s is None:
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
        seconds, line = offset_s, f"clocks: {offset_s:g} s, as given"
    return _joined(tracks, columns, seconds), line


def with_analog_forces(tracks: Tracks, mapping: Path | None) -> tuple[Tracks, str]:
    """The tracks with the forces in channels of their own file, which are on the same clock."""
    assert tracks.analog is not None, "a file with analog channels"
    sources = {} if mapping is None else read_columns(mapping)
    columns = mapped(tracks.analog, sources).columns | {TIME: tracks.analog.columns[TIME]}
    if not all(column.name in columns for column in READINGS):
        names = listed(name for name in tracks.analog.columns if name != TIME)
        wanted = f"{READINGS[0].name} ... {READINGS[-1].name}"
        raise InputError(
            f"{tracks.path}: has the channels {names}, and says of none that it is a load cell's; "
            f"allowed: --columns FILE that names those of {wanted}, or --forces FILE"
        )
    hz = 1.0 / (columns[TIME][1] - columns[TIME][0])
    return _joined(tracks, columns, 0.0), f"forces: of the file's own channels, {hz:g} Hz"


def _joined(tracks: Tracks, columns: dict[str, Array], seconds: float) -> Tracks:
    """Rows that the forces cover; where those are about a point, moments are carried to the mouthpiece."""
    time, at = columns[TIME], tracks.time + seconds
    rows = (at >= time[0]) & (at <= time[-1])
    if rows.sum() < 2:
        raise InputError(f"{tracks.path}: shares {rows.sum()} rows with the forces; allowed: two or more (the offset?)")
    names = [*(column.name for column in READINGS), *(POINT if POINT[0] in columns else ())]
    table = np.column_stack([np.interp(at[rows], time, columns[name]) for name in names])
    steps = np.diff(time)
    before = np.clip(np.searchsorted(time, at[rows], side="right") - 1, 0, len(steps) - 1)
    between = (time[before] < at[rows]) & (at[rows] < time[before + 1])
    table[between & (steps[before] > LONGEST_GAP * np.median(steps))] = np.nan
    places, turned, wrench = tracks.places[BODY][rows], tracks.rotations[BODY][rows], table[:, :6]
    if table.shape[1] > 6:
        wrench = at_mouthpiece(wrench, table[:, 6:], places, turned)
    parts = {BODY: places}, {BODY: turned}, {BODY: wrench}
    return replace(tracks, time=tracks.time[rows], places=parts[0], rotations=parts[1], wrenches=parts[2])


def at_mouthpiece(wrench: Array, point: Array, place: Array, turned: Array) -> Array:
    """A wrench (T, 6) about a point, carried to the mouthpiece.

    Args:
        wrench: N and N m, body axes.
        point: (T, 3) mm, head axes.
        place: (T, 3) mm of the mouthpiece, head axes.
        turned: (T, 3, 3) body axes to head axes.
    """
    arm = 1e-3 * (turned.transpose(0, 2, 1) @ (point - place)[..., None])[..., 0]
    return np.hstack([wrench[:, :3], wrench[:, 3:] + np.cross(arm, wrench[:, :3])])


def only_wrench(tracks: Tracks) -> tuple[Array, Array | None]:
    """(T, 6) of the file's only wrench, forward, left and up, and the point (T, 3) in mm that it is about."""
    if len(tracks.wrenches) != 1:
        raise InputError(f"{tracks.path}: has {len(tracks.wrenches)} wrenches; allowed: one, of force and moment")
    ((name, load),) = tracks.wrenches.items()
    axes = tracks.axes.get(name, np.eye(3))
    point = tracks.points.get(name)
    moment = np.sign(np.linalg.det(axes)) * load[:, 3:] @ axes.T
    return np.hstack([load[:, :3] @ axes.T, moment]), None if point is None else point @ axes.T


def _force_columns(path: Path, mapping: Path | None) -> dict[str, Array]:
    """Columns of a recording, by name: of a CSV or Parquet file, or of the only wrench of a MOT or STO file."""
    if path.suffix in FORMATS:
        return mapped(read_table(path, WORDS), {} if mapping is None else read_columns(mapping)).columns
    if path.suffix not in (".mot", ".sto"):
        raise InputError(f"{path}: the ending is {path.suffix!r}; allowed: {', '.join((*FORMATS, '.mot', '.sto'))}")
    tracks = read_opensim(path, None)
    wrench, point = only_wrench(tracks)
    columns = {TIME: tracks.time} | {column.name: values for column, values in zip(READINGS, wrench.T, strict=True)}
    return columns if point is None else columns | dict(zip(POINT, point.T, strict=True))
