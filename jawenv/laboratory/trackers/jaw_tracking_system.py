"""HDF5 files of JawTrackingSystem (https://github.com/paulotto/jaw_tracking_system, docs/HDF5_ANALYSIS.md).

A group is the motion of a mandibular landmark: ``translations`` (T, 3) in the group's ``unit``, ``rotations`` as (T, 4)
quaternions (w, x, y, z) or (T, 3, 3) matrices, and ``sample_rate`` in Hz.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from jawenv.errors import InputError, shown
from jawenv.extras import needs
from jawenv.laboratory.trackers.tracks import Array, Tracks, millimetres


def read_jaw_tracking_system(path: Path, unit: str | None) -> Tracks:
    """Read every group as a body.

    Raises:
        InputError: no HDF5 file, a truncated one, a missing data set or attribute, or groups of several rates.
        MissingPackageError: h5py is not installed.
    """
    with needs("HDF5", "h5py", extra="mocap"):
        import h5py
    places: dict[str, Array] = {}
    rotations: dict[str, Array] = {}
    rates = set()
    try:
        with h5py.File(path, "r") as file:
            for name, group in file.items():
                places[name], rotations[name], rate = _body(group, unit, f"{path}: {name}")
                rates.add((rate, len(places[name])))
    except OSError as error:
        raise InputError(f"{path}: {' '.join(str(error).split())[:120]}; allowed: a whole HDF5 file") from None
    if len(rates) != 1:
        raise InputError(
            f"{path}: groups have the rates and lengths {sorted(rates)}; allowed: one group, or alike ones"
        )
    rate, length = rates.pop()
    return Tracks(str(path), np.arange(length) / rate, places, rotations)


def _body(group: Any, unit: str | None, where: str) -> tuple[Array, Array, float]:
    """Places (T, 3) in mm, rotations (T, 3, 3) and rate in Hz of a group."""
    for part, names in (("data set", ("translations", "rotations")), ("attribute", ("sample_rate",))):
        for name in names:
            if name not in (group if part == "data set" else group.attrs):
                raise InputError(f"{where}: {part} {name!r} is missing; allowed: as JawTrackingSystem writes it")
    translations, turned = np.asarray(group["translations"], float), np.asarray(group["rotations"], float)
    if translations.shape[1:] != (3,) or turned.shape not in ((len(translations), 4), (len(translations), 3, 3)):
        shapes = f"{translations.shape} and {turned.shape}"
        raise InputError(f"{where}: translations and rotations have shapes {shapes}; allowed: (T, 3), (T, 4 or 3, 3)")
    rate = group.attrs["sample_rate"]
    if not (np.ndim(rate) == 0 and np.isreal(rate) and 0.0 < float(rate) < np.inf):
        raise InputError(f"{where}: sample_rate is {shown(rate)}; allowed: a number above 0")
    stated = group.attrs.get("unit")
    if turned.ndim == 2:
        turned = matrices(turned)
    return translations * millimetres(unit or (None if stated is None else str(stated)), where), turned, float(rate)


def matrices(quaternions: Array) -> Array:
    """(T, 3, 3) rotation matrices of quaternions (T, 4), w first; NaN where a quaternion is not finite or 0."""
    result = np.full((len(quaternions), 3, 3), np.nan)
    seen = np.isfinite(quaternions).all(axis=1) & (np.abs(quaternions).sum(axis=1) > 0.0)
    result[seen] = Rotation.from_quat(quaternions[seen], scalar_first=True).as_matrix()
    return result
