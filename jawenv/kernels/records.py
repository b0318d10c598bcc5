"""Records whose large fields begin where a vector register is filled in one access, and arrays of them.

A load of 64 bytes that lies in two lines of the processor's cache takes twice as long. NumPy puts an array wherever
there is room, so that the same program ran at 110 or 146 microseconds a step.
"""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

LINE = 64  # bytes of a line of the cache
Array: TypeAlias = NDArray[np.float64]


def record_dtype(fields: type | list[Any], **sizes: int | np.dtype[np.void]) -> np.dtype[np.void]:
    """A dtype of ``fields``; those of a line or more begin at one, and so does the next record.

    Args:
        fields: As for ``np.dtype``, or a class whose annotations name them, so that mypy knows them in kernels:
            a number's type, ``Annotated[Array, 3, "lines"]`` with the lengths of an array, or another such class.
        sizes: Lengths that the class has names for; dtypes of fields with such a class, where it has other lengths.
    """
    if isinstance(fields, type):
        hints = get_type_hints(fields, include_extras=True)
        fields = [(name, *_format(hint, sizes.get(name), sizes)) for name, hint in hints.items()]
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


def _format(hint: Any, dtype: Any, sizes: dict[str, Any]) -> tuple[Any, ...]:
    """Format of a field with this annotation, as ``np.dtype`` takes it."""
    if get_origin(hint) is Annotated:
        array, *lengths = get_args(hint)
        number = get_args(array)[-1]  # from NumPy 2.5 and Python 3.12 on; before, the dtype of it
        number = get_args(number)[0] if get_origin(number) is np.dtype else number
        return number, tuple(sizes.get(length, length) for length in lengths)
    if hint in (int, float, bool) or issubclass(hint, np.generic):
        return (np.uint8 if hint is bool else hint,)
    return (dtype if isinstance(dtype, np.dtype) else record_dtype(hint, **sizes),)


def record_zeros(shape: int | tuple[int, ...], dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Zeros of ``dtype``, from the beginning of a line of the cache on."""
    size = int(np.prod(shape)) * dtype.itemsize
    room = np.zeros(size + LINE, dtype=np.uint8)
    first = -room.ctypes.data % LINE
    return room[first : first + size].view(dtype).reshape(shape)


@intrinsic
def _copy_record(typing: Any, target: Any, source: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        cgutils.raw_memcpy(builder, values[0], values[1], ir.Constant(ir.IntType(64), target.size), 1)
        return context.get_dummy_value()

    return types.none(target, source), generate


copy_record: Any = _copy_record
