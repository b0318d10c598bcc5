"""Motion and storage files of OpenSim (MOT, STO).

A body ``NAME`` has the columns ``NAME_tx``, ``_ty``, ``_tz`` (m) and ``NAME_rx``, ``_ry``, ``_rz``: body-fixed angles,
turned in the order z, y, x. A wrench has ``NAME_force_vx`` ... (N) and ``NAME_torque_x`` ... (N m), as external loads.
OpenSim's axes point forward, up and right.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.errors import InputError, shown
from jawenv.files import write_text
from jawenv.laboratory.recordings.dialects import decoded
from jawenv.laboratory.recordings.table import DIGITS, LARGEST_RECORDING
from jawenv.laboratory.trackers.tracks import Array, Tracks, millimetres, numbers, whole

AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From OpenSim's axes to forward, left and up."""
PLACE, ANGLES = ("tx", "ty", "tz"), ("rz", "ry", "rx")
WRENCH = ("force_vx", "force_vy", "force_vz", "torque_x", "torque_y", "torque_z")
BODY = "jaw"


def read_opensim(path: Path, unit: str | None) -> Tracks:
    """Read a MOT or STO file; lengths are in m where no other unit is given.

    Raises:
        InputError: no such file, a truncated one, no ``inDegrees``, or a body or wrench without one of its columns.
    """
    lines = list(enumerate(decoded(path, LARGEST_RECORDING).splitlines(), 1))
    end = next((i for i, (_, text) in enumerate(lines) if text.strip() == "endheader"), None)
    if end is None or len(lines) < end + 2:
        raise InputError(f"{path}: line 'endheader' is missing; allowed: a MOT or STO file")
    header = dict(
        text.replace("=", " ").split(None, 1) for _, text in lines[:end] if len(text.replace("=", " ").split()) > 1
    )
    names = lines[end + 1][1].split()
    if names[:1] != ["time"]:
        raise InputError(f"{path}: the first column is {shown(names[0] if names else '')}; allowed: time")
    table = numbers(str(path), [line for line in lines[end + 2 :] if line[1].strip()], names, None)
    whole(str(path), len(table), header.get("nRows", header.get("datarows", "")).strip(), "nRows")
    columns = dict(zip(names, table.T, strict=True))
    degrees = header.get("inDegrees", "").strip()
    if degrees not in ("yes", "no"):
        raise InputError(f"{path}: inDegrees is {shown(degrees)}; allowed: yes or no")
    places = {
        name: group * millimetres(unit or "m", str(path)) for name, group in _groups(columns, PLACE, path).items()
    }
    rotations = {
        name: Rotation.from_euler("ZYX", angles, degrees=degrees == "yes").as_matrix()
        for name, angles in _groups(columns, ANGLES, path).items()
        if name in places
    }
    return Tracks(str(path), columns["time"], places, rotations, _groups(columns, WRENCH, path), AXES)


def _groups(columns: dict[str, Array], endings: tuple[str, ...], path: Path) -> dict[str, Array]:
    """(T, n) of each name that has a column with one of the n endings, and so must have all."""
    found = {name.removesuffix(f"_{end}"): None for name in columns for end in endings if name.endswith(f"_{end}")}
    for name in found:
        for end in endings:
            if f"{name}_{end}" not in columns:
                raise InputError(f"{path}: column {shown(f'{name}_{end}')} is missing; allowed: all of its group")
    return {name: np.column_stack([columns[f"{name}_{end}"] for end in endings]) for name in found}


def write_opensim(tracks: Tracks, path: Path) -> None:
    """Write the body ``jaw`` and its wrench, whose axes are forward, left and up.

    Raises:
        InputError: the file cannot be written.
    """
    turned = AXES.T @ tracks.rotations[BODY] @ AXES
    angles = np.full((len(turned), 3), np.nan)
    seen = np.isfinite(turned).all(axis=(1, 2))
    angles[seen] = Rotation.from_matrix(turned[seen]).as_euler("ZYX", degrees=True)
    names = [f"{BODY}_{end}" for end in (*PLACE, *ANGLES)]
    columns = [tracks.places[BODY] @ AXES / 1e3, angles]
    if BODY in tracks.wrenches:
        names += [f"{BODY}_{end}" for end in WRENCH]
        columns += [tracks.wrenches[BODY][:, :3] @ AXES, tracks.wrenches[BODY][:, 3:] @ AXES]
    table = np.column_stack([tracks.time, *columns])
    head = [path.stem, "version=1", f"nRows={len(table)}", f"nColumns={table.shape[1]}", "inDegrees=yes", "endheader"]
    rows = ["\t".join(f"{value:.{DIGITS}g}" for value in row) for row in table]
    write_text(path, "\n".join([*head, "\t".join(["time", *names]), *rows, ""]))
