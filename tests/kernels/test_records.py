"""Where the fields of records lie in memory."""

from typing import Annotated

import numpy as np
import pytest
from numpy.typing import NDArray

from jawenv.envs.world.record import world_dtype
from jawenv.envs.world.step_kernel import scratch_dtype
from jawenv.kernels.records import LINE, Array, record_dtype, record_zeros

FIELDS = [("flag", "u1"), ("number", "f8"), ("wide", "f8", (3, 5)), ("bytes", "u1", (70,)), ("last", "f4")]


@pytest.mark.parametrize("shape", [1, 3, (2, 3), 0])
def test_every_record_begins_at_a_line_and_is_zero(shape):
    records = record_zeros(shape, record_dtype(FIELDS))
    assert records.shape == ((shape,) if isinstance(shape, int) else shape)
    for record in records.reshape(-1):
        for name in ("wide", "bytes"):
            assert record[name].ctypes.data % LINE == 0
            assert not record[name].any()


@pytest.mark.parametrize("dtype", [world_dtype(6, 6, 10, 0, 0), scratch_dtype(6, 6, 10)])
def test_nested_records_keep_their_alignment(dtype):
    def check(kind, start):
        for name in kind.names:
            field, offset = kind.fields[name][:2]
            if field.itemsize >= LINE:
                assert (start + offset) % LINE == 0, name
            if field.names:
                check(field, start + offset)

    check(dtype, 0)


class Part:
    count: int
    flags: Annotated[NDArray[np.uint8], "columns"]


class Whole:
    flag: bool
    kind: np.uint8
    number: float
    wide: Annotated[Array, 3, "columns"]
    part: Part
    other: Part


class Longer(Whole):
    last: Annotated[Array, "rows"]


def test_a_record_of_a_class_is_that_of_its_fields():
    part, other = ([("count", "i8"), ("flags", "u1", (size,))] for size in (5, 2))
    fields = [("flag", "u1"), ("kind", "u1"), ("number", "f8"), ("wide", "f8", (3, 5))]
    fields += [("part", record_dtype(part)), ("other", record_dtype(other))]
    given = record_dtype(Part, columns=2)
    assert record_dtype(Whole, columns=5, other=given) == record_dtype(fields)
    assert record_dtype(Longer, columns=5, rows=0, other=given) == record_dtype([*fields, ("last", "f8", (0,))])
