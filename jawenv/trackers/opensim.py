"""Motion and storage files of OpenSim (MOT, STO), of its versions 1 to 4 and of SIMM.

A body ``NAME`` has the columns ``NAME_tx``, ``_ty``, ``_tz`` (m) and ``NAME_rx``, ``_ry``, ``_rz``: body-fixed angles,
turned in the order z, y, x; or, of the analysis BodyKinematics, ``NAME_X`` ... ``NAME_Oz``, in the order x, y, z.
A wrench has ``NAME_force_vx`` ... (N) and ``NAME_torque_x`` ... (N m), as external loads, or ``..._force_1_vx`` and
``..._moment_1_mx``. It is about the mouthpiece, or about the point ``NAME_force_px`` ... (m) where the file has one.
OpenSim's axes point forward, up and right.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.base.errors import InputError, shown
from jawenv.base.files import write_text
from jawenv.recordings.dialects import decoded
from jawenv.recordings.table import DIGITS, LARGEST_RECORDING
from jawenv.trackers.tracks import Array, Tracks, check_rows, listed, millimetres, numbers

AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation from OpenSim's axes to forward, left and up."""
PLACE, ANGLES = ("_tx", "_ty", "_tz"), ("_rz", "_ry", "_rx")
BODY_PLACE, BODY_ANGLES = ("_X", "_Y", "_Z"), ("_Ox", "_Oy", "_Oz")
"""Columns of BodyKinematics."""
FORCE, TORQUE = ("_force_vx", "_force_vy", "_force_vz"), ("_torque_x", "_torque_y", "_torque_z")
SIMM = ("datarows", "indegrees")
BODY = "jaw"


def read_opensim(path: Path, unit: str | None) -> Tracks:
    """Read a MOT or STO file; lengths are in m where neither the file nor the argument says otherwise."""
    header, names, table = _header_and_table(path)
    columns = dict(zip(names, table.T, strict=True))
    if len(columns) != len(names):
        raise InputError(f"{path}: a column stands there twice; allowed: once")
    turned = _groups(columns, ANGLES, path), _groups(columns, BODY_ANGLES, path)
    if any(turned) and header.get("indegrees") not in ("yes", "no"):
        raise InputError(f"{path}: inDegrees is {shown(header.get('indegrees', ''))}; allowed: yes or no")
    if turned[1] and header["title"].casefold().startswith(("velocit", "acceler")):
        raise InputError(f"{path}: holds {shown(header['title'])}; allowed: positions, as ..._pos_global.sto")
    scale = millimetres(unit or header.get("units") or "m", str(path))
    places = {
        name: scale * group for ending in (PLACE, BODY_PLACE) for name, group in _groups(columns, ending, path).items()
    }
    degrees = header.get("indegrees") == "yes"
    rotations = {
        name: _rotations(order, angles, degrees)
        for order, groups in zip(("ZYX", "XYZ"), turned, strict=True)
        for name, angles in groups.items()
        if name in places
    }
    wrenches, points = _wrenches(columns, scale, path)
    if not places and not wrenches:
        allowed = "NAME_tx ... NAME_rz of a body, NAME_X ... NAME_Oz of BodyKinematics, NAME_force_vx ... of a wrench"
        raise InputError(f"{path}: holds no body and no wrench, but {listed(names[:9])}; allowed: columns {allowed}")
    axes = dict.fromkeys([*places, *wrenches], AXES)
    return Tracks(str(path), columns["time"], places, rotations, wrenches, points, axes)


def _header_and_table(path: Path) -> tuple[dict[str, str], list[str], Array]:
    """Words of the header by their names in small letters, the columns' names, and the rows."""
    lines = list(enumerate(decoded(path, LARGEST_RECORDING).splitlines(), 1))
    end = next((i for i, (_, text) in enumerate(lines) if text.strip().casefold() == "endheader"), None)
    if end is None or len(lines) < end + 2:
        raise InputError(f"{path}: line 'endheader' is missing; allowed: a MOT or STO file")
    header = {"title": lines[0][1].strip()}
    for _, text in lines[:end]:
        word, separator, value = text.partition("=")
        if not separator:  # as SIMM writes it
            word, _, value = text.strip().partition(" ")
        if separator or word.casefold() in SIMM:
            header[word.strip().casefold()] = value.strip().casefold()
    names = lines[end + 1][1].split()
    if not names or names[0].casefold() != "time":
        raise InputError(f"{path}: the first column is {shown(names[0] if names else '')}; allowed: time")
    names[0] = "time"
    table = numbers(str(path), [line for line in lines[end + 2 :] if line[1].strip()], names, None)
    check_rows(str(path), len(table), header.get("nrows", header.get("datarows")), "nRows")
    return header, names, table


def _rotations(order: str, angles: Array, degrees: bool) -> Array:
    turned = np.full((len(angles), 3, 3), np.nan)
    seen = np.isfinite(angles).all(axis=1)
    turned[seen] = Rotation.from_euler(order, angles[seen], degrees=degrees).as_matrix()
    return turned


def _groups(columns: dict[str, Array], endings: tuple[str, ...], path: Path) -> dict[str, Array]:
    """(T, n) of each name that has a column with one of the n endings, and so must have all."""
    found = {name.removesuffix(end): None for name in columns for end in endings if name.endswith(end)}
    return {name: _stacked(columns, [f"{name}{end}" for end in endings], path) for name in found}


def _stacked(columns: dict[str, Array], names: list[str], path: Path) -> Array:
    for name in names:
        if name not in columns:
            raise InputError(f"{path}: column {shown(name)} is missing; allowed: all of its group")
    return np.column_stack([columns[name] for name in names])


def _wrenches(columns: dict[str, Array], scale: float, path: Path) -> tuple[dict[str, Array], dict[str, Array]]:
    """Wrenches by their names, and the points (mm) where those act that have one."""
    wrenches, points = {}, {}
    forces = {match[1]: None for name in columns if (match := re.fullmatch(r"(.*force_(?:\d+_)?)[vp][xyz]", name))}
    torques = {match[1]: None for name in columns if (match := re.fullmatch(r"(.*torque_(?:\d+_)?)[xyz]", name))}
    for torque in torques:
        forces.setdefault(torque.replace("torque_", "force_"), None)
    for force in forces:
        name = force.partition("force_")[0].rstrip("_") + force.partition("force_")[2].rstrip("_")
        kinds = [f"{force.replace('force_', 'moment_')}m", force.replace("force_", "torque_")]
        moment = next((kind for kind in kinds if f"{kind}x" in columns), kinds[1])
        load = _stacked(columns, [f"{force}v{axis}" for axis in "xyz"], path)
        acts = any(f"{force}p{axis}" in columns for axis in "xyz")
        if acts:
            points[name] = scale * _stacked(columns, [f"{force}p{axis}" for axis in "xyz"], path)
        free = acts and not any(f"{moment}{axis}" in columns for axis in "xyz")
        twist = np.zeros_like(load) if free else _stacked(columns, [f"{moment}{axis}" for axis in "xyz"], path)
        wrenches[name] = np.hstack([load, twist])
    return wrenches, points


def write_opensim(tracks: Tracks, path: Path) -> None:
    """Write the body ``jaw`` and its wrench about the mouthpiece; both are in forward, left and up."""
    turned = AXES.T @ tracks.rotations[BODY] @ AXES
    angles = np.full((len(turned), 3), np.nan)
    seen = np.isfinite(turned).all(axis=(1, 2))
    angles[seen] = Rotation.from_matrix(turned[seen]).as_euler("ZYX", degrees=True)
    names = [f"{BODY}{end}" for end in (*PLACE, *ANGLES)]
    columns = [tracks.places[BODY] @ AXES / 1e3, angles]
    if BODY in tracks.wrenches:
        names += [f"{BODY}{end}" for end in (*FORCE, *TORQUE)]
        columns += [tracks.wrenches[BODY][:, :3] @ AXES, tracks.wrenches[BODY][:, 3:] @ AXES]
    table = np.column_stack([tracks.time, *columns])
    head = [path.stem, "version=1", f"nRows={len(table)}", f"nColumns={table.shape[1]}", "inDegrees=yes", "endheader"]
    rows = ["\t".join(f"{value:.{DIGITS}g}" for value in row) for row in table]
    write_text(path, "\n".join([*head, "\t".join(["time", *names]), *rows, ""]))
