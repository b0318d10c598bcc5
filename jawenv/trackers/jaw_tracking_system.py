"""HDF5 files of JawTrackingSystem (https://github.com/paulotto/jaw_tracking_system, docs/HDF5_ANALYSIS.md).

A group is the motion of a mandibular landmark: ``translations`` (T, 3) in the group's ``unit``, ``rotations`` as (T, 4)
quaternions (w, x, y, z) or (T, 3, 3) matrices, and ``sample_rate`` in Hz.
"""

from __future__ import annotations

import importlib.util
import io
import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.errors import InputError, MissingPackageError, reason_of, shown
from jawenv.base.reading import open_file
from jawenv.trackers import hdf5_groups
from jawenv.trackers.tracks import Array, Tracks, is_rate, matrices, millimetres

LARGEST = 128 * 2**20
"""Bytes of all arrays."""
SECONDS = 15
"""Time limit for reading, which takes a second."""


def read_jaw_tracking_system(path: Path, unit: str | None) -> Tracks:
    """Read every group as a body; data sets and links beside the groups are passed over.

    Raises:
        InputError: no HDF5 file, a truncated one, a missing data set or attribute, or groups of several rates.
        MissingPackageError: h5py is not installed.
    """
    groups, arrays = _read_in_process(path)
    places: dict[str, Array] = {}
    rotations: dict[str, Array] = {}
    rates = set()
    for group in groups:
        name, where = group["name"], f"{path}: {shown(group['name'])}"
        rate = _rate(group, where)
        places[name], rotations[name] = _body(next(arrays), next(arrays), group, unit, where)
        rates.add((rate, len(places[name])))
    if len(rates) != 1:
        raise InputError(
            f"{path}: groups have the rates and lengths {shown(sorted(rates))}; allowed: one group, or alike ones"
        )
    rate, length = rates.pop()
    return Tracks(str(path), np.arange(length) / rate, places, rotations)


def _read_in_process(path: Path) -> tuple[list[dict[str, Any]], Any]:
    """The file's groups and their arrays, read by a process of its own."""
    if importlib.util.find_spec("h5py") is None:
        raise MissingPackageError('HDF5 needs h5py: pip install "jawenv[mocap]"')
    with open_file(path):
        pass
    command = [sys.executable, "-P", hdf5_groups.__file__, str(path.absolute()), str(LARGEST)]
    try:
        ran = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise InputError(f"{path}: is not read within {SECONDS} s; allowed: a whole HDF5 file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {reason_of(error)}") from None
    try:
        line, _, rest = ran.stdout.partition(b"\n")
        told = json.loads(line)
    except ValueError:
        raise InputError(f"{path}: its reader ended with {ran.returncode}; allowed: a whole HDF5 file") from None
    if "refused" in told:
        raise InputError(f"{path}: {told['refused']}; allowed: a whole HDF5 file, and plain data sets in it")
    for group in told["groups"]:
        for part in hdf5_groups.PARTS:
            if part not in group["parts"]:
                where = f"{path}: {shown(group['name'])}"
                raise InputError(f"{where}: data set {part!r} is missing; allowed: as JawTrackingSystem writes it")
    stream = io.BytesIO(rest)
    return told["groups"], (np.load(stream, allow_pickle=False) for _ in range(2 * len(told["groups"])))


def _rate(group: Mapping[str, Any], where: str) -> float:
    rate = group["attributes"]["sample_rate"]
    if rate is None:
        raise InputError(f"{where}: attribute 'sample_rate' is missing; allowed: as JawTrackingSystem writes it")
    if not is_rate(rate):
        raise InputError(f"{where}: sample_rate is {shown(rate)}; allowed: a number above 0")
    return float(rate)


def _body(
    translations: Array, turned: Array, group: Mapping[str, Any], unit: str | None, where: str
) -> tuple[Array, Array]:
    """Places (T, 3) in mm and rotations (T, 3, 3); NaN where a matrix or quaternion is 0."""
    if translations.shape[1:] != (3,) or turned.shape not in ((len(translations), 4), (len(translations), 3, 3)):
        shapes = f"{translations.shape} and {turned.shape}"
        raise InputError(f"{where}: translations and rotations have shapes {shapes}; allowed: (T, 3), (T, 4 or 3, 3)")
    stated = group["attributes"]["unit"]
    if not isinstance(stated, str | None):
        raise InputError(f"{where}: unit is {shown(stated)}; allowed: a text, as mm")
    turned = matrices(turned) if turned.ndim == 2 else turned
    turned[(turned == 0.0).all(axis=(1, 2))] = np.nan
    with np.errstate(over="ignore"):
        return translations * millimetres(unit or stated, where), turned
