"""Opening of every file from outside: a regular file of a limited size, or one line that says what is wrong.

A pipe or a device would be read for ever. Archives and arrays state their size at the top: what they state is checked
before anything of it is read.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from typing import BinaryIO

from jawenv.base.errors import InputError, reason_of

MIB = 2**20
LARGEST_TEXT = 8 * MIB
"""Bytes of a file of settings, a maneuver or a patient."""
LARGEST_DATA = 1024 * MIB
"""Bytes of a file of numbers, as it lies on the disk and as it is unpacked."""

_KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


@contextlib.contextmanager
def open_file(path: str | os.PathLike[str], largest: int = LARGEST_DATA) -> Iterator[BinaryIO]:
    """Open a regular file, or a link to one, for reading.

    Args:
        path: of the file.
        largest: size that is allowed, bytes.

    Yields:
        The open file.
    """
    name = os.fspath(path)
    try:
        # Without O_NONBLOCK, opening a pipe waits for its writer.
        descriptor = os.open(name, os.O_RDONLY | os.O_CLOEXEC | os.O_NOCTTY | os.O_NONBLOCK)
    except FileNotFoundError:
        raise InputError(f"{name}: no such file") from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise InputError(f"{name}: cannot be read: {reason_of(error)}") from None
    try:
        _check(name, os.fstat(descriptor), largest)
    except InputError:
        os.close(descriptor)
        raise
    with os.fdopen(descriptor, "rb") as file:
        yield file


def read_bytes(path: str | os.PathLike[str], largest: int = LARGEST_DATA) -> bytes:
    """The content of a file; arguments and errors as of `open_file`."""
    with open_file(path, largest) as file:
        try:
            content = file.read(largest + 1)
        except OSError as error:
            raise InputError(f"{os.fspath(path)}: cannot be read: {reason_of(error)}") from None
    if len(content) > largest:  # it grew, or is of a kind that states no size
        raise InputError(_too_large(os.fspath(path), len(content), largest))
    return content


def read_text(path: str | os.PathLike[str], largest: int = LARGEST_TEXT, encoding: str = "utf-8") -> str:
    """The content of a text file; arguments and errors as of `open_file`.

    Raises:
        UnicodeDecodeError: it is no text.
    """
    return read_bytes(path, largest).decode(encoding).replace("\r\n", "\n").replace("\r", "\n")


def _check(name: str, status: os.stat_result, largest: int) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise InputError(f"{name}: cannot be read: Is a directory")
    if not stat.S_ISREG(status.st_mode):
        kind = next((kind for is_kind, kind in _KINDS if is_kind(status.st_mode)), "of an unknown kind")
        raise InputError(f"{name}: is {kind}; allowed: a regular file")
    if status.st_size > largest:
        raise InputError(_too_large(name, status.st_size, largest))


def _too_large(name: str, size: int, largest: int) -> str:
    return f"{name}: has {size:,} bytes; allowed: {largest:,} at most"
