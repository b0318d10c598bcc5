"""BIDS-Motion: ``*_motion.tsv`` without names, ``*_channels.tsv`` with them, ``*_motion.json``, ``*_channels.json``.

https://bids-specification.readthedocs.io/en/stable/modality-specific-files/motion.html
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.base.errors import InputError, shown
from jawenv.base.files import read_mapping
from jawenv.recordings.dialects import decoded, number
from jawenv.recordings.mapping import factor
from jawenv.recordings.table import LARGEST_RECORDING
from jawenv.trackers.bids_frames import Frame, read_frames
from jawenv.trackers.tracks import Array, Tracks, is_rate, millimetres, numbers

MOTION = "_motion.tsv"
HEADER = ("name", "component", "type", "tracked_point", "units")
AXES, QUATERNION = ("x", "y", "z"), ("quat_w", "quat_x", "quat_y", "quat_z")
BODY = "jaw"
Channel = dict[str, str]


def read_bids_motion(path: Path, unit: str | None) -> Tracks:
    """Read positions (POS) and orientations (ORNT) of all tracked points.

    Times are those of a LATENCY channel, or else of the effective, or else the nominal rate.
    """
    if not path.name.endswith(MOTION):
        raise InputError(f"{path}: the name ends otherwise; allowed: {MOTION}")
    channels = _channels(_companion(path, "_channels.tsv"))
    text = decoded(path, LARGEST_RECORDING).splitlines()
    rows = [(i, line) for i, line in enumerate(text, 1) if line.strip()]
    table = numbers(str(path), rows, [channel["name"] for channel in channels], "\t")
    about, frames = read_mapping(path.with_suffix(".json")), read_frames(_companion(path, "_channels.json"))
    time = _times(channels, table, about, path)
    missing = number(str(about.get("MissingValues", "")).strip())
    if missing is not None:
        table[table == missing] = np.nan
    groups: dict[tuple[str, str], dict[str, Array]] = defaultdict(dict)
    stands: dict[str, str] = {}
    for channel, values in zip(channels, table.T, strict=True):
        point, kind, where = channel["tracked_point"], channel["type"].upper(), f"{path}: {shown(channel['name'])}"
        if kind not in ("POS", "ORNT"):
            continue
        component = channel["component"].lower()
        if component in groups[kind, point]:
            raise InputError(f"{where}: {component} of {shown(point)} stands there twice; allowed: once")
        groups[kind, point][component] = _scale(channel, unit, where) * _heard(channel, values)
        frame = channel.get("reference_frame", "")
        if stands.setdefault(point, frame) != frame:
            raise InputError(f"{where}: reference_frame is another than before; allowed: one for each tracked point")
    places = {point: _stacked(group, AXES, path) for (kind, point), group in groups.items() if kind == "POS"}
    used = {point: frames.of(stands[point]) for point in stands}
    rotations = {
        point: _rotations(group, used[point], path)
        for (kind, point), group in groups.items()
        if kind == "ORNT" and point in places
    }
    axes = {point: each.axes for point, each in used.items() if each.axes is not None}
    return Tracks(str(path), time, places, rotations, axes=axes, frames=stands)


def _companion(path: Path, ending: str) -> Path:
    return path.with_name(path.name.removesuffix(MOTION) + ending)


def _channels(path: Path) -> list[Channel]:
    lines = [line.split("\t") for line in decoded(path, LARGEST_RECORDING).splitlines() if line.strip()]
    names = [name.strip() for name in lines[0]] if lines else []
    for name in HEADER:
        if name not in names:
            raise InputError(f"{path}: column {name!r} is missing; allowed: {', '.join(HEADER)}")
    for i, line in enumerate(lines, 1):
        if len(line) != len(names):
            raise InputError(f"{path}: row {i} has {len(line)} values; allowed: {len(names)}, one per column")
    return [dict(zip(names, (cell.strip() for cell in line), strict=True)) for line in lines[1:]]


def _times(channels: list[Channel], table: Array, about: Mapping[str, Any], path: Path) -> Array:
    """(T,) s."""
    latencies = [i for i, channel in enumerate(channels) if channel["type"].upper() == "LATENCY"]
    if len(latencies) > 1:
        raise InputError(f"{path}: has {len(latencies)} channels of type LATENCY; allowed: one")
    if latencies:
        unit = _stated(channels[latencies[0]]["units"]) or "s"
        latency: Array = factor("time_s", unit, str(path)) * table[:, latencies[0]]
        return latency
    stated = about.get("SamplingFrequency")
    nominal, effective = _rate(stated), _rate(about.get("SamplingFrequencyEffective"))
    if nominal is None:
        raise InputError(
            f"{path.with_suffix('.json')}: SamplingFrequency is {shown(stated)}; allowed: a number above 0"
        )
    for channel in channels:
        own = number(channel.get("sampling_frequency", ""))
        if own is None or abs(own - nominal) > 1e-6 * own:
            what = f"{shown(channel['name'])} has the sampling_frequency {shown(channel['sampling_frequency'])}"
            raise InputError(f"{path}: {what}; allowed: the file's {nominal:g} Hz")
    times: Array = np.arange(len(table)) / (effective or nominal)
    return times


def _rate(value: Any) -> float | None:
    return float(value) if is_rate(value) else None


def _stated(units: str) -> str | None:
    return None if units.lower() in ("", "n/a") else units


def _heard(channel: Channel, values: Array) -> Array:
    """The values, none of a channel that is stated to be bad."""
    return np.full_like(values, np.nan) if channel.get("status", "").lower() == "bad" else values


def _scale(channel: Channel, unit: str | None, where: str) -> float:
    """The factor to mm, or to degrees of an Euler angle."""
    kind, component = channel["type"].upper(), channel["component"].lower()
    if kind == "POS":
        return millimetres(unit or _stated(channel["units"]), where)
    return factor("pitch_deg", channel["units"], where) if component in AXES else 1.0


def _stacked(group: Mapping[str, Array], components: tuple[str, ...], path: Path) -> Array:
    for component in components:
        if component not in group:
            raise InputError(f"{path}: channel of component {component!r} is missing; allowed: {', '.join(components)}")
    return np.column_stack([group[component] for component in components])


def _rotations(group: Mapping[str, Array], frame: Frame, path: Path) -> Array:
    """(T, 3, 3) of quaternions, or of Euler angles in degrees that follow each other about axes at rest."""
    sign = frame.sign(str(path))
    if set(group) <= set(AXES):
        angles = sign * _stacked(group, tuple(axis.lower() for axis in frame.order(str(path))), path)
        turned = np.full((len(angles), 3, 3), np.nan)
        seen = np.isfinite(angles).all(axis=1)
        turned[seen] = Rotation.from_euler(frame.order(str(path)).lower(), angles[seen], degrees=True).as_matrix()
        return turned
    return matrices(_stacked(group, QUATERNION, path) * [1.0, sign, sign, sign])


def matrices(quaternions: Array) -> Array:
    """(T, 3, 3) rotation matrices of quaternions (T, 4), w first; NaN where a quaternion is not finite or 0."""
    result = np.full((len(quaternions), 3, 3), np.nan)
    largest = np.abs(quaternions).max(axis=1, initial=0.0, keepdims=True)
    seen = np.isfinite(quaternions).all(axis=1) & (largest[:, 0] > 1e-100)
    unit = quaternions[seen] / largest[seen]  # squares of others may be too large or too small
    result[seen] = Rotation.from_quat(unit, scalar_first=True).as_matrix()
    return result


def parts_of(path: Path) -> list[Path]:
    """The four files that belong together."""
    return [path, _companion(path, "_channels.tsv"), _companion(path, "_channels.json"), path.with_suffix(".json")]
