"""Marker files: C3D (https://www.c3d.org) and TRC of OpenSim."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from jawenv.errors import InputError, shown
from jawenv.extras import needs
from jawenv.laboratory.recordings.dialects import decoded
from jawenv.laboratory.recordings.table import LARGEST_RECORDING
from jawenv.laboratory.trackers.tracks import Tracks, millimetres, numbers, whole

BLOCK = 512
"""Bytes of a C3D file's block."""
INTEL = 84
"""Mark of little-endian numbers."""
TRC_HEAD = 5
"""Lines of a TRC file above its rows."""


def read_c3d(path: Path, unit: str | None) -> Tracks:
    """Read the points of a C3D file; a point with a negative residual is a lost one.

    Raises:
        InputError: no C3D file, a truncated one, or no unit.
        MissingPackageError: ezc3d is not installed.
    """
    with needs("C3D", "ezc3d", extra="mocap"):
        import ezc3d
    try:
        content = ezc3d.c3d(str(path))
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(f"{path}: {' '.join(str(error).split())[:120]}; allowed: a C3D file") from None
    points = content["data"]["points"]
    parameters = {name: entry["value"] for name, entry in content["parameters"]["POINT"].items() if name[0] != "_"}
    _check_whole(path)
    rate = float(parameters["RATE"][0])
    if not rate > 0.0:
        raise InputError(f"{path}: POINT:RATE is {rate:g}; allowed: a number above 0")
    scale = millimetres(unit or "".join(parameters.get("UNITS", [""])[:1]), str(path))
    places = {name: scale * points[:3, i].T for i, name in enumerate(parameters["LABELS"][: points.shape[1]])}
    return Tracks(str(path), np.arange(points.shape[2]) / rate, places)


def _check_whole(path: Path) -> None:
    """Check that a file has the bytes that its header promises: ezc3d passes over missing frames."""
    content = path.read_bytes()
    points, analog, first, last = struct.unpack_from("<4H", content, 2)
    scale, start = struct.unpack_from("<fH", content, 12)
    parameters = (content[0] - 1) * BLOCK
    if content[parameters + 3] != INTEL:
        return
    needed = (start - 1) * BLOCK + (last - first + 1) * (4 * points + analog) * (4 if scale < 0.0 else 2)
    if len(content) < needed:
        raise InputError(f"{path}: has {len(content):,} bytes; allowed: {needed:,} or more (a truncated file?)")


def read_trc(path: Path, unit: str | None) -> Tracks:
    """Read a TRC file.

    Raises:
        InputError: no TRC file, a truncated one, or no unit.
    """
    lines = list(enumerate(decoded(path, LARGEST_RECORDING).splitlines(), 1))
    if len(lines) < TRC_HEAD or not lines[0][1].startswith("PathFileType"):
        raise InputError(f"{path}: begins with {shown(lines[0][1] if lines else '')}; allowed: PathFileType, as TRC")
    header = dict(zip(lines[1][1].split("\t"), lines[2][1].split("\t"), strict=False))
    labels = [name.strip() for name in lines[3][1].split("\t")]
    markers = [name for name in labels[2:] if name]
    if labels[:2] != ["Frame#", "Time"]:
        raise InputError(f"{path}: column 'Frame#' or 'Time' is missing; allowed: both, first")
    if str(len(markers)) != header.get("NumMarkers", "").strip():
        stated = shown(header.get("NumMarkers", ""))
        raise InputError(f"{path}: has {len(markers)} markers; allowed: {stated}, its NumMarkers")
    names = ["Frame#", "Time", *(f"{marker} {axis}" for marker in markers for axis in "XYZ")]
    table = numbers(str(path), [line for line in lines[TRC_HEAD:] if line[1].strip()], names, "\t")
    whole(str(path), len(table), header.get("NumFrames", "").strip(), "NumFrames")
    scale = millimetres(unit or header.get("Units"), str(path))
    places = {name: scale * table[:, 2 + 3 * i : 5 + 3 * i] for i, name in enumerate(markers)}
    return Tracks(str(path), table[:, 1], places)
