"""Where the fields of records lie in memory."""

import ast
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from numpy.typing import NDArray

import jawenv
from jawenv.envs.world.record import world_dtype
from jawenv.envs.world.step_kernel import scratch_dtype
from jawenv.kernels.records import LINE, Array, record_dtype, record_zeros

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


DECORATORS = ("njit", "where", "world_kernel")
# The modules of these records import the kernels.
UNNAMED = {
    "force_sensor.py": "truth",
    "refocus.py": "scratch",
    "instrument.py": "scratch",
    "changes.py": "scratch",
    "without_cell.py": "scratch",
    "screening.py": "scratch",
}
ON_ARRAYS = {"any", "all", "copy", "shape", "size"}


def test_kernels_name_the_records_whose_fields_they_use():
    """So that mypy sees a misspelt field."""
    named = 0
    for path in Path(jawenv.__file__).parent.rglob("*.py"):
        for kernel in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(kernel, ast.FunctionDef) or "njit" not in str(
                [ast.dump(d) for d in kernel.decorator_list]
            ):
                continue
            annotations = {argument.arg: argument.annotation for argument in kernel.args.args}
            for use in ast.walk(kernel):
                if not isinstance(use, ast.Attribute) or not isinstance(use.value, ast.Name) or use.attr in ON_ARRAYS:
                    continue
                name = use.value.id
                if name in annotations and UNNAMED.get(path.name) != name:
                    assert annotations[name] is not None, f"{path}:{use.lineno}: {name}.{use.attr}"
                    named += 1
    assert named > 1000
