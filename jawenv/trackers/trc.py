"""Marker files of OpenSim (TRC)."""

from __future__ import annotations

from pathlib import Path

from jawenv.base.errors import InputError, shown
from jawenv.recordings.dialects import decoded
from jawenv.recordings.table import LARGEST_RECORDING
from jawenv.trackers.tracks import Tracks, check_rows, distinct, millimetres, numbers

HEAD = 5
"""Lines above the rows."""


def read_trc(path: Path, unit: str | None) -> Tracks:
    """Read a TRC file."""
    lines = list(enumerate(decoded(path, LARGEST_RECORDING).splitlines(), 1))
    if len(lines) < HEAD or not lines[0][1].startswith("PathFileType"):
        raise InputError(f"{path}: begins with {shown(lines[0][1] if lines else '')}; allowed: PathFileType, as TRC")
    words = [[word.strip() for word in line[1].split("\t")] for line in lines[1:3]]
    header = dict(zip((word.casefold() for word in words[0]), words[1], strict=False))
    labels = [name.strip() for name in lines[3][1].split("\t")]
    markers = [name for name in labels[2:] if name]
    if [label.casefold().replace(" ", "") for label in labels[:2]] != ["frame#", "time"]:
        raise InputError(f"{path}: column 'Frame#' or 'Time' is missing; allowed: both, first")
    if header.get("nummarkers", str(len(markers))) != str(len(markers)):
        stated = shown(header["nummarkers"])
        raise InputError(f"{path}: has {len(markers)} markers; allowed: {stated}, its NumMarkers")
    names = ["Frame#", "Time", *(f"{marker} {axis}" for marker in markers for axis in "XYZ")]
    table = numbers(str(path), [line for line in lines[HEAD:] if line[1].strip()], names, "\t")
    check_rows(str(path), len(table), header.get("numframes"), "NumFrames")
    scale = millimetres(unit or header.get("units"), str(path))
    places = {name: scale * table[:, 2 + 3 * i : 5 + 3 * i] for i, name in enumerate(distinct(markers))}
    return Tracks(str(path), table[:, 1], places)
