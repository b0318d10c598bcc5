"""Named arrays in one file (.npz), written whole or not at all, and read without unpickling."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError
from jawenv.files import atomic_write


def save_arrays(path: Path, **arrays: Any) -> None:
    """Write arrays by their names.

    Raises:
        InputError: the file cannot be written.
    """
    with atomic_write(path) as unfinished, unfinished.open("wb") as file:
        np.savez_compressed(file, **arrays)


def load_arrays(path: Path, names: tuple[str, ...], what: str) -> tuple[NDArray[Any], ...]:
    """Read the arrays of these names.

    Args:
        path: the file.
        names: of the arrays.
        what: what they are, for the message.

    Raises:
        InputError: no such file, a damaged one, or one without these arrays.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as held:
            return tuple(held[name] for name in names)
    except OSError as error:
        reason = error.strerror or str(error)
    except (EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
        reason = " ".join(str(error).split())[:120]
    raise InputError(f"{path}: no {what}: {reason}")
