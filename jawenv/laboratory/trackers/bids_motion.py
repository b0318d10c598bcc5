"""BIDS-Motion: ``*_motion.tsv`` without names, ``*_channels.tsv`` with them, ``*_motion.json``, ``*_channels.json``.

https://bids-specification.readthedocs.io/en/stable/modality-specific-files/motion.html
"""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.errors import InputError, shown
from jawenv.files import read_mapping, write_text
from jawenv.laboratory.recordings.dialects import decoded
from jawenv.laboratory.recordings.table import DIGITS, LARGEST_RECORDING
from jawenv.laboratory.trackers.jaw_tracking_system import matrices
from jawenv.laboratory.trackers.tracks import Array, Tracks, millimetres, numbers

MOTION = "_motion.tsv"
HEADER = ("name", "component", "type", "tracked_point", "units")
AXES, QUATERNION = ("x", "y", "z"), ("quat_w", "quat_x", "quat_y", "quat_z")
WRENCH = tuple(f"{kind}_{axis}" for kind in ("force", "moment") for axis in AXES)
DIRECTIONS = {"A": (1, 0, 0), "P": (-1, 0, 0), "L": (0, 1, 0), "R": (0, -1, 0), "S": (0, 0, 1), "I": (0, 0, -1)}
"""Letters of SpatialAxes in forward, left and up."""
BODY = "jaw"


def read_bids_motion(path: Path, unit: str | None) -> Tracks:
    """Read positions (POS) and quaternions (ORNT) of all tracked points, and wrenches as this module writes them.

    Raises:
        InputError: another ending, a missing companion file, column, channel or unit, or a damaged row.
    """
    if not path.name.endswith(MOTION):
        raise InputError(f"{path}: the name ends otherwise; allowed: {MOTION}")
    stem = path.name.removesuffix(MOTION)
    channels = _channels(path.with_name(f"{stem}_channels.tsv"))
    text = decoded(path, LARGEST_RECORDING).splitlines()
    rows = [(i, line) for i, line in enumerate(text, 1) if line.strip()]
    table = numbers(str(path), rows, [channel["name"] for channel in channels], "\t")
    groups: dict[tuple[str, str], dict[str, Array]] = defaultdict(dict)
    for channel, values in zip(channels, table.T, strict=True):
        point, kind = channel["tracked_point"], channel["type"].upper()
        scale = millimetres(unit or _stated(channel["units"]), f"{path}: {channel['name']}") if kind == "POS" else 1.0
        component = channel["component"] if kind != "MISC" else channel["name"].removeprefix(f"{point}_")
        groups[kind, point][component] = scale * values
    places = {point: _stacked(group, AXES, path) for (kind, point), group in groups.items() if kind == "POS"}
    turned = {point: group for (kind, point), group in groups.items() if kind == "ORNT"}
    rotations = {point: matrices(_stacked(group, QUATERNION, path)) for point, group in turned.items()}
    loads = {point: group for (kind, point), group in groups.items() if kind == "MISC" and set(group) & set(WRENCH)}
    wrenches = {point: _stacked(group, WRENCH, path) for point, group in loads.items()}
    rate = read_mapping(path.with_suffix(".json")).get("SamplingFrequency")
    if isinstance(rate, bool) or not (isinstance(rate, int | float) and 0.0 < rate < np.inf):
        raise InputError(f"{path.with_suffix('.json')}: SamplingFrequency is {shown(rate)}; allowed: a number above 0")
    return Tracks(str(path), np.arange(len(table)) / rate, places, rotations, wrenches, _axes(path, stem))


def _channels(path: Path) -> list[dict[str, str]]:
    lines = [line.split("\t") for line in decoded(path, LARGEST_RECORDING).splitlines() if line.strip()]
    for name in HEADER:
        if name not in lines[0]:
            raise InputError(f"{path}: column {name!r} is missing; allowed: {', '.join(HEADER)}")
    return [dict(zip(lines[0], (cell.strip() for cell in line), strict=False)) for line in lines[1:]]


def _stated(units: str) -> str | None:
    return None if units.lower() in ("", "n/a") else units


def _stacked(group: dict[str, Array], components: tuple[str, ...], path: Path) -> Array:
    for component in components:
        if component not in group:
            raise InputError(f"{path}: channel of component {component!r} is missing; allowed: {', '.join(components)}")
    return np.column_stack([group[component] for component in components])


def _axes(path: Path, stem: str) -> Array | None:
    """From the file's axes to forward, left and up, where ``*_channels.json`` states them."""
    beside = path.with_name(f"{stem}_channels.json")
    if not beside.exists():
        return None
    levels = read_mapping(beside).get("reference_frame", {}).get("Levels", {})
    letters = {str(level.get("SpatialAxes")) for level in levels.values()}
    if len(letters) != 1:
        return None
    stated = letters.pop()
    axes = np.array([DIRECTIONS.get(letter, (0, 0, 0)) for letter in stated], dtype=np.float64).T
    if axes.shape != (3, 3) or round(float(np.linalg.det(axes))) != 1:
        allowed = "right-handed axes of the letters A or P, L or R, S or I, as ALS"
        raise InputError(f"{beside}: SpatialAxes is {shown(stated)}; allowed: {allowed}")
    return axes


def write_bids_motion(tracks: Tracks, path: Path) -> None:
    """Write the body ``jaw`` and its wrench, whose axes are forward, left and up, with the three files beside.

    Raises:
        InputError: a file cannot be written.
    """
    turned = tracks.rotations[BODY]
    quaternions = np.full((len(turned), 4), np.nan)
    seen = np.isfinite(turned).all(axis=(1, 2))
    quaternions[seen] = Rotation.from_matrix(turned[seen]).as_quat(scalar_first=True)
    channels = [(f"{BODY}_{axis}", axis, "POS", BODY, "mm", "head") for axis in AXES]
    channels += [(f"{BODY}_{part}", part, "ORNT", BODY, "n/a", "head") for part in QUATERNION]
    columns = [tracks.places[BODY], quaternions]
    if BODY in tracks.wrenches:
        units = ["N"] * 3 + ["N m"] * 3
        channels += [
            (f"{BODY}_{part}", "n/a", "MISC", BODY, each, "n/a") for part, each in zip(WRENCH, units, strict=True)
        ]
        columns.append(tracks.wrenches[BODY])
    table = np.column_stack(columns)
    rows = ["\t".join("n/a" if np.isnan(value) else f"{value:.{DIGITS}g}" for value in row) for row in table]
    names = ["\t".join(channel) for channel in ((*HEADER, "reference_frame"), *channels)]
    rate = (len(tracks.time) - 1) / (tracks.time[-1] - tracks.time[0])
    stem = path.name.removesuffix(MOTION)
    frame = {"SpatialAxes": "ALS", "RotationRule": "right-hand", "Description": "from midway between the condyles"}
    about = {"TaskName": "jaw", "SamplingFrequency": round(float(rate), DIGITS), "TrackedPointsCount": 1}
    write_text(path.with_name(f"{stem}_channels.tsv"), "\n".join([*names, ""]))
    write_text(path.with_name(f"{stem}_channels.json"), json.dumps({"reference_frame": {"Levels": {"head": frame}}}))
    write_text(path.with_suffix(".json"), json.dumps(about))
    write_text(path, "\n".join([*rows, ""]))
