"""The lines of all muscles at once: a number for each line, in the lanes of a vector register.

``all_lines(array)`` is an index that stands for all rows of a field of a record. Where a kernel is called with it in
place of a row's number, ``array[i]`` is a ``Lanes``: as many numbers, with the operators, ``sqrt`` and ``exp`` of one.
So the same kernel serves one line and all of them, and reads like the equation. ``total`` is the sum over the lines; of
one line it is that line's number.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel.models import OpaqueModel, PrimitiveModel
from numba.extending import intrinsic, lower_builtin, register_model, type_callable
from numba.np.arrayobj import getitem_array_tuple

_NUMBER, _WHOLE, _PLACE = ir.DoubleType(), ir.IntType(64), ir.IntType(32)
_FLAGS = ("contract",)


class Lanes(types.Type):
    """Type of a number for each of ``count`` lines."""

    def __init__(self, count: int) -> None:
        """A register holds a power of two."""
        self.count, self.width = count, 1 << (count - 1).bit_length()
        super().__init__(name=f"Lanes({count})")


class _AllLines(types.Type):
    """Type of the index that stands for all of ``count`` rows."""

    def __init__(self, count: int) -> None:
        """An index of as many rows as a compiler can see."""
        self.count = count
        super().__init__(name=f"_AllLines({count})")


@register_model(Lanes)
class _LanesModel(PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, ir.VectorType(_NUMBER, fe_type.width))


register_model(_AllLines)(OpaqueModel)


@intrinsic
def _all_lines(typing: Any, array: Any) -> Any:
    result = _AllLines(array.shape[0])
    return result(array), lambda context, builder, signature, values: context.get_dummy_value()


all_lines: Any = _all_lines


def _constant(kind: Lanes, value: float) -> Any:
    return ir.Constant(ir.VectorType(_NUMBER, kind.width), [value] * kind.width)


def _as_lanes(context: Any, builder: Any, kind: Any, value: Any, lanes: Lanes) -> Any:
    """A value as a vector: itself, or a number in all lanes."""
    if isinstance(kind, Lanes):
        return value
    number = context.cast(builder, value, kind, types.float64)
    nothing = ir.Constant(ir.VectorType(_NUMBER, lanes.width), ir.Undefined)
    one = builder.insert_element(nothing, number, ir.Constant(_PLACE, 0))
    return builder.shuffle_vector(one, nothing, ir.Constant(ir.VectorType(_PLACE, lanes.width), [0] * lanes.width))


def _define_operator(function: Any, of_two: Callable[..., Any]) -> None:
    """Two ``Lanes``, or one and a number."""

    @type_callable(function)
    def _(context: Any) -> Callable[..., Any]:
        def typer(a: Any, b: Any) -> Any:
            for one, other in ((a, b), (b, a)):
                if isinstance(one, Lanes) and (other == one or isinstance(other, types.Number)):
                    return one
            return None

        return typer

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        pairs = zip(signature.args, values, strict=True)
        a, b = (_as_lanes(context, builder, kind, value, signature.return_type) for kind, value in pairs)
        return of_two(builder, a, b)

    for kinds in ((Lanes, Lanes), (Lanes, types.Number), (types.Number, Lanes)):
        lower_builtin(function, *kinds)(generate)


def _choose(comparison: str) -> Callable[..., Any]:
    """The smaller or the larger of two: the first where the comparison with the second holds."""
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(comparison, a, b), a, b)


def _arithmetic(instruction: str) -> Callable[..., Any]:
    return lambda builder, a, b: getattr(builder, instruction)(a, b, flags=_FLAGS)


for _function, _of_two in (
    (operator.add, _arithmetic("fadd")),
    (operator.sub, _arithmetic("fsub")),
    (operator.mul, _arithmetic("fmul")),
    (operator.truediv, _arithmetic("fdiv")),
    (min, _choose("<")),
    (max, _choose(">")),
):
    _define_operator(_function, _of_two)


def _define_function(function: Any, generate: Callable[[Any, Lanes, Any], Any]) -> None:
    """A function of one ``Lanes``; ``generate`` gets the builder, the type and the value."""

    @type_callable(function)
    def _(context: Any) -> Callable[[Any], Any]:
        return lambda x: x if isinstance(x, Lanes) else None

    @lower_builtin(function, Lanes)
    def _(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return generate(builder, signature.args[0], values[0])


def _negative(builder: Any, kind: Lanes, x: Any) -> Any:
    return builder.fneg(x)


def _root(builder: Any, kind: Lanes, x: Any) -> Any:
    vector = ir.VectorType(_NUMBER, kind.width)
    name = f"llvm.sqrt.v{kind.width}f64"
    return builder.call(cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [vector]), name), [x])


LARGEST_EXPONENT = 700.0  # beyond it the exponential is that of the limit


def _exponential(builder: Any, kind: Lanes, x: Any) -> Any:
    """2^k exp(r) with |r| <= ln(2) / 2, exp(r) by its series to r^13: about one unit in the last place."""

    def constant(value: float) -> Any:
        return _constant(kind, value)

    def plus(a: Any, b: Any) -> Any:
        return builder.fadd(a, b, flags=_FLAGS)

    def times(a: Any, b: Any) -> Any:
        return builder.fmul(a, b, flags=_FLAGS)

    for sign, limit in ((">", constant(LARGEST_EXPONENT)), ("<", constant(-LARGEST_EXPONENT))):
        x = builder.select(builder.fcmp_ordered(sign, x, limit), limit, x)
    # Adding 1.5 * 2^52 rounds to a whole number, which stands in the lowest bits.
    rounder = constant(6755399441055744.0)
    shifted = builder.fadd(builder.fmul(x, constant(1.0 / math.log(2.0))), rounder)
    k = builder.fsub(shifted, rounder)
    # ln(2) in two parts, the first of which has zeros in its last bits, so that k times it is exact.
    r = builder.fsub(x, times(k, constant(6.93147180369123816490e-01)), flags=_FLAGS)
    r = builder.fsub(r, times(k, constant(1.90821492927058770002e-10)), flags=_FLAGS)
    terms = [1.0 / math.factorial(n) for n in range(14)]
    z = times(r, r)
    w = times(z, z)
    pairs = [plus(constant(terms[n]), times(r, constant(terms[n + 1]))) for n in range(2, 13, 2)]
    fours = [plus(pairs[n], times(z, pairs[n + 1])) for n in (0, 2, 4)]
    tail = plus(fours[0], times(w, plus(fours[1], times(w, fours[2]))))
    value = plus(constant(1.0), plus(r, times(z, tail)))
    wholes = ir.VectorType(_WHOLE, kind.width)
    power = builder.add(builder.bitcast(shifted, wholes), ir.Constant(wholes, [1023] * kind.width))
    power = builder.shl(power, ir.Constant(wholes, [52] * kind.width))
    return builder.fmul(value, builder.bitcast(power, ir.VectorType(_NUMBER, kind.width)))


_define_function(operator.neg, _negative)
_define_function(math.sqrt, _root)
_define_function(math.exp, _exponential)


@intrinsic
def _total(typing: Any, lanes: Any) -> Any:
    if isinstance(lanes, types.Float):
        return lanes(lanes), lambda context, builder, signature, values: values[0]

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kind, vector = signature.args[0], values[0]
        zero = ir.Constant(_NUMBER, 0.0)
        for lane in range(kind.count, kind.width):
            vector = builder.insert_element(vector, zero, ir.Constant(_PLACE, lane))
        width = kind.width
        while width > 1:
            width //= 2
            halves = [
                builder.shuffle_vector(
                    vector,
                    vector,
                    ir.Constant(ir.VectorType(_PLACE, width), list(range(first, first + width))),
                )
                for first in (0, width)
            ]
            vector = builder.fadd(*halves)
        return builder.extract_element(vector, ir.Constant(_PLACE, 0))

    return types.float64(lanes), generate


@intrinsic
def _lane(typing: Any, lanes: Any, lane: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.extract_element(values[0], builder.trunc(values[1], _PLACE))

    return types.float64(lanes, types.int64), generate


total: Any = _total
lane: Any = _lane


def _is_rows(array: Any, index: Any) -> Any:
    """The ``AllLines`` of an index [i] of a vector or [i, column] of a matrix."""
    if not isinstance(array, types.Array):
        return None
    several: Any = types.BaseTuple
    parts = [*index] if isinstance(index, several) else [index]
    whole = all(isinstance(column, types.Integer) for column in parts[1:])
    return parts[0] if isinstance(parts[0], _AllLines) and len(parts) == array.ndim <= 2 and whole else None


@type_callable(operator.getitem)
def _(context: Any) -> Callable[..., Any]:
    def typer(array: Any, index: Any) -> Any:
        rows = _is_rows(array, index)
        return Lanes(rows.count) if rows is not None else None

    return typer


def _column(context: Any, builder: Any, kind: Any, index: Any, value: Any) -> list[Any]:
    """The column of an index [all lines, column] of a matrix; nothing for a vector."""
    if kind.ndim == 1:
        return []
    return [context.cast(builder, builder.extract_value(value, 1), index[1], types.intp)]


def _gather(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """A number of every row; lanes beyond the last row repeat the first."""
    kind, index = signature.args
    result: Lanes = signature.return_type
    array = context.make_array(kind)(context, builder, values[0])
    columns = _column(context, builder, kind, index, values[1])
    vector, first = ir.Constant(ir.VectorType(_NUMBER, result.width), ir.Undefined), None
    for lane in range(result.width):
        if lane < result.count:
            where = [ir.Constant(_WHOLE, lane), *columns]
            pointer = cgutils.get_item_pointer(context, builder, kind, array, where)
            value = context.cast(builder, context.unpack_value(builder, kind.dtype, pointer), kind.dtype, types.float64)
            first = value if first is None else first
        else:
            value = first
        vector = builder.insert_element(vector, value, ir.Constant(_PLACE, lane))
    return vector


lower_builtin(operator.getitem, types.Array, _AllLines)(_gather)


@type_callable(operator.setitem)
def _(context: Any) -> Callable[..., Any]:
    def typer(array: Any, index: Any, value: Any) -> Any:
        rows = _is_rows(array, index)
        return types.void if rows is not None and isinstance(value, Lanes) else None

    return typer


@lower_builtin(operator.setitem, types.Array, _AllLines, Lanes)
@lower_builtin(operator.setitem, types.Array, types.Tuple, Lanes)
def _(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """A number into every row."""
    kind, index, lanes = signature.args
    array = context.make_array(kind)(context, builder, values[0])
    columns = _column(context, builder, kind, index, values[1])
    for lane in range(lanes.count):
        where = [ir.Constant(_WHOLE, lane), *columns]
        pointer = cgutils.get_item_pointer(context, builder, kind, array, where)
        builder.store(builder.extract_element(values[2], ir.Constant(_PLACE, lane)), pointer)
    return context.get_dummy_value()


@lower_builtin(operator.getitem, types.Array, types.Tuple)
def _(context: Any, builder: Any, signature: Any, values: Any) -> Any:
    """Get a place by indices of different types; Numba's own way where none stands for all lines."""
    chosen = _gather if isinstance(signature.return_type, Lanes) else getitem_array_tuple
    return chosen(context, builder, signature, values)
