"""Reads the groups of an HDF5 file, as a program of its own: damaged files make the library hang, or end the process.

    python hdf5_groups.py FILE LARGEST_BYTES

It imports nothing of jawenv. On its standard output: a line of JSON, with a list of groups or with what is refused,
and the arrays of each group, one after the other.
"""

from __future__ import annotations

import io
import json
import sys
from typing import Any

import numpy as np

PARTS = ("translations", "rotations")
SECONDS = 10
"""Limit of computing time."""
BYTES = 2**32
"""Limit of address space."""
MOST_GROUPS = 100


def main(path: str, largest: int) -> None:
    """Write the groups of a file to the standard output."""
    import h5py

    limit()
    arrays: list[Any] = []
    try:
        with h5py.File(path, "r") as file:
            told: dict[str, Any] = {"groups": _groups_of(h5py, file, largest, arrays)}
    except Exception as error:
        told, arrays = {"refused": f"{' '.join(str(error).split())[:150]}"}, []
    sys.stdout.buffer.write(json.dumps(told).encode() + b"\n")
    for array in arrays:
        stream = io.BytesIO()  # a pipe has no position, which NumPy asks a file for
        np.save(stream, array, allow_pickle=False)
        sys.stdout.buffer.write(stream.getbuffer())


def limit() -> None:
    """Bound time and memory, where the system can."""
    try:
        import resource
    except ImportError:
        return
    for kind, most in ((resource.RLIMIT_CPU, SECONDS), (resource.RLIMIT_AS, BYTES)):
        try:
            hard = resource.getrlimit(kind)[1]
            resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
        except (OSError, ValueError):
            continue


def _groups_of(h5py: Any, file: Any, largest: int, arrays: list[Any]) -> list[dict[str, Any]]:
    """Facts about each group with translations or rotations; the arrays of a group with both go to ``arrays``."""
    found: list[dict[str, Any]] = []
    left = largest
    for name in file:
        if not isinstance(file.get(name, getlink=True), h5py.HardLink) or file.get(name, getclass=True) != h5py.Group:
            continue
        group = file[name]
        names = set(group)  # asking for one would follow its link
        present = [part for part in PARTS if part in names]
        if not present and "sample_rate" not in group.attrs:
            continue
        if len(found) == MOST_GROUPS:
            raise ValueError(f"more than {MOST_GROUPS} groups")
        about = {word: _attribute(group.attrs, word) for word in ("sample_rate", "unit")}
        found.append({"name": name, "parts": present, "attributes": about})
        if len(present) == len(PARTS):
            for part in PARTS:
                dataset = checked(h5py, group, part, f"{name}/{part}", left)
                left -= 8 * dataset.size
                arrays.append(np.asarray(dataset[()], dtype=np.float64))
    return found


def checked(h5py: Any, group: Any, part: str, where: str, left: int) -> Any:
    """A data set of numbers in the file itself, of which no more is stored or stated than may be read."""
    if not isinstance(group.get(part, getlink=True), h5py.HardLink):
        raise ValueError(f"{where} is a link to elsewhere")
    dataset = group[part]
    if not isinstance(dataset, h5py.Dataset) or dataset.is_virtual or dataset.external:
        raise ValueError(f"{where} is no data set of this file")
    if dataset.dtype.kind not in "iuf" or dataset.shape is None:
        raise ValueError(f"{where} holds {str(dataset.dtype)[:40]}, no numbers")
    if 8 * dataset.size > left:
        raise ValueError(f"{where} takes {8 * dataset.size:,} bytes of {left:,} that are allowed")
    return dataset


def _attribute(attributes: Any, word: str) -> Any:
    """A text or a number, also as an array of one; None for nothing, and a list for what is neither."""
    if word not in attributes:
        return None
    value = attributes[word]
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.reshape(-1)[0]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, str):
        return value
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        return float(value)
    return [type(value).__name__]


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
