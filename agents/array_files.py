"""Named arrays in one file (.npz), written whole or not at all, and read without unpickling."""

from __future__ import annotations

import math
import struct
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.base.files import atomic_write
from jawenv.base.reading import open_file

LARGEST_ARRAY = 256 * 2**20
"""Bytes: the actions of a thousand patients over ten minutes take 200 MB."""
_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
_DAMAGE = (
    OSError,
    EOFError,
    LookupError,
    TypeError,
    ValueError,
    ArithmeticError,
    RuntimeError,  # an encrypted archive; with it NotImplementedError and RecursionError
    SyntaxError,
    tokenize.TokenError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)
"""Exceptions that NumPy raises on a damaged archive of arrays."""


def save_arrays(path: Path, **arrays: Any) -> None:
    """Write arrays by their names."""
    with atomic_write(path) as unfinished, unfinished.open("wb") as file:
        np.savez_compressed(file, **arrays)


def load_arrays(path: Path, names: tuple[str, ...], what: str) -> tuple[NDArray[Any], ...]:
    """Read the arrays of these names.

    Args:
        path: the file.
        names: of the arrays.
        what: noun for the arrays in the message.
    """
    with open_file(path) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                return tuple(_array(archive, f"{name}.npy") for name in names)
        except _DAMAGE as error:
            reason = " ".join(str(error).split())[:120] or type(error).__name__
        except MemoryError:
            reason = "more than the memory holds"
    raise InputError(f"{path}: no {what}: {reason}")


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """An array, whose size is checked before memory is taken for it.

    Raises:
        ValueError: the header asks for another number of bytes than the member holds, or for objects.
    """
    held = archive.getinfo(name).file_size
    if held > LARGEST_ARRAY:
        raise ValueError(f"{name} has {held:,} bytes; allowed: {LARGEST_ARRAY:,} at most")
    with archive.open(name) as member:
        version = np.lib.format.read_magic(member)
        if version not in _HEADERS:
            raise ValueError(f"{name} is of format {version}; allowed: {', '.join(map(str, _HEADERS))}")
        shape, _, dtype = _HEADERS[version](member)
        asked = math.prod(shape) * dtype.itemsize
        if dtype.hasobject or min(shape, default=0) < 0 or asked != held - member.tell():
            raise ValueError(f"{name} asks for {asked:,} bytes of {dtype}, it holds {held - member.tell():,}")
        member.seek(0)
        array: NDArray[Any] = np.lib.format.read_array(member, allow_pickle=False)
        return array
