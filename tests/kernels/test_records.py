"""Where the fields of records lie in memory."""

import numpy as np
import pytest

from jawenv.envs.world.record import world_dtype
from jawenv.envs.world.step_kernel import scratch_dtype
from jawenv.kernels.records import LINE, record_dtype, record_zeros

FIELDS = [("flag", "u1"), ("number", "f8"), ("wide", "f8", (3, 5)), ("bytes", "u1", (70,)), ("last", "f4")]


def test_large_fields_begin_at_a_line_and_small_ones_where_they_fit():
    dtype = record_dtype(FIELDS)
    offsets = {name: dtype.fields[name][1] for name in dtype.names}
    assert offsets["flag"] == 0
    assert offsets["number"] == 8
    assert offsets["wide"] % LINE == offsets["bytes"] % LINE == 0
    assert offsets["last"] % 4 == 0
    assert dtype.itemsize % LINE == 0
    ends = [dtype.fields[name][1] + dtype.fields[name][0].itemsize for name in dtype.names]
    assert all(end <= start for end, start in zip(ends, list(offsets.values())[1:], strict=False))


def test_a_record_without_a_large_field_is_as_numpy_aligns_it():
    fields = FIELDS[:2]
    assert record_dtype(fields).itemsize == np.dtype(fields, align=True).itemsize


@pytest.mark.parametrize("shape", [1, 3, (2, 3), 0])
def test_every_record_begins_at_a_line_and_is_zero(shape):
    records = record_zeros(shape, record_dtype(FIELDS))
    assert records.shape == ((shape,) if isinstance(shape, int) else shape)
    for record in records.reshape(-1):
        for name in ("wide", "bytes"):
            assert record[name].ctypes.data % LINE == 0
            assert not record[name].any()


@pytest.mark.parametrize("dtype", [world_dtype(6, 6, 10, 0, 0, 0), scratch_dtype(6, 6, 10)])
def test_nested_records_keep_their_alignment(dtype):
    def check(kind, start):
        for name in kind.names:
            field, offset = kind.fields[name][:2]
            if field.itemsize >= LINE:
                assert (start + offset) % LINE == 0, name
            if field.names:
                check(field, start + offset)

    check(dtype, 0)
