"""Records whose large fields begin where a vector register is filled in one access, and arrays of them.

A load of 64 bytes that lies in two lines of the processor's cache takes twice as long. NumPy puts an array wherever
there is room, so that the same program ran at 110 or 146 microseconds a step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

LINE = 64  # bytes of a line of the cache


def record_dtype(fields: list[Any]) -> np.dtype[np.void]:
    """A dtype of ``fields``, as for ``np.dtype``; those of a line or more begin at one, and so does the next record."""
    plain = np.dtype(fields, align=True)
    names, formats, offsets, offset, widest = list(plain.names or ()), [], [], 0, plain.alignment
    for name in names:
        kind = plain.fields[name][0]  # type: ignore[index]
        step = LINE if kind.itemsize >= LINE else kind.alignment
        offset = -(-offset // step) * step
        formats.append(kind)
        offsets.append(offset)
        offset += kind.itemsize
        widest = max(widest, step)
    size = -(-offset // widest) * widest
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size}, align=True)


def record_zeros(shape: int | tuple[int, ...], dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Zeros of ``dtype``, from the beginning of a line of the cache on."""
    size = int(np.prod(shape)) * dtype.itemsize
    room = np.zeros(size + LINE, dtype=np.uint8)
    first = -room.ctypes.data % LINE
    return room[first : first + size].view(dtype).reshape(shape)
