"""Small matrices in records: products and triangular solves with all sums in vector registers.

Numba compiles a kernel that takes fields of records for arrays of any size: sizes and overlaps are tested at run time
and sums go through memory. Here the sizes are read from the types, and each row is written as vectors of up to ``WIDE``
numbers. Sums run in the order of the plain loops. A product and its sum are rounded once (a fused multiply-add).

Arguments are fields of records (their types hold the sizes) of doubles, and do not overlap unless a docstring says so.
``decompose`` takes any matrix. What else follows from its factor is in ``cholesky``.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import Any

from llvmlite import binding, ir
from numba import config, types
from numba.core import cgutils, errors
from numba.extending import intrinsic

from jawenv.kernels.compiled import njit


def _features() -> set[str]:
    """Features of this processor for which Numba compiles."""
    asked: str | None = getattr(config, "CPU_FEATURES", None)
    if asked is not None:
        return {name[1:] for name in asked.split(",") if name.startswith("+")}
    return {name for name, has in binding.get_host_cpu_features().items() if has}


WIDE = 8  # numbers that are written as one vector: a register of AVX-512, two of AVX2
SUMS = 20 if "avx512f" in _features() else 6
"""Vectors that a product adds up at once, of the 32 or 8 that registers hold: more are put aside and taken back."""
_FLAGS = ("contract",)
_INDEX, _NUMBER = ir.IntType(64), ir.DoubleType()


def _blocks(size: int) -> list[tuple[int, int]]:
    """First column and width of the vectors that make up a row of ``size`` numbers."""
    blocks, first = [], 0
    while first < size:
        width = next(w for w in (WIDE, 4, 2, 1) if w <= size - first)
        blocks.append((first, width))
        first += width
    return blocks


def _index(value: int) -> Any:
    return ir.Constant(_INDEX, value)


def _spread(builder: Any, number: Any, width: int) -> Any:
    """A vector with ``number`` in all places."""
    nothing = ir.Constant(ir.VectorType(_NUMBER, width), ir.Undefined)
    one = builder.insert_element(nothing, number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, nothing, ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width))


class _Matrix:
    """A field of a record: its data, its shape, its numbers as vectors."""

    def __init__(self, context: Any, builder: Any, kind: Any, value: Any) -> None:
        self.builder = builder
        self.data = context.make_array(kind)(context, builder, value).data
        self.rows, self.columns = kind.shape
        self.blocks = _blocks(self.columns)

    def _at(self, row: Any, offset: Any) -> Any:
        start = self.builder.mul(row, _index(self.columns))
        offset = _index(offset) if isinstance(offset, int) else offset
        return self.builder.gep(self.data, [self.builder.add(start, offset)])

    def number(self, row: Any, offset: Any) -> Any:
        return self.builder.load(self._at(row, offset))

    def vector(self, row: Any, offset: Any, width: int) -> Any:
        kind = ir.VectorType(_NUMBER, width)
        return self.builder.load(self.builder.bitcast(self._at(row, offset), kind.as_pointer()), align=8)

    def store(self, value: Any, row: Any, offset: Any, width: int) -> None:
        kind = ir.VectorType(_NUMBER, width)
        self.builder.store(value, self.builder.bitcast(self._at(row, offset), kind.as_pointer()), align=8)


def _checked(name: str, matrices: tuple[Any, ...], fits: Callable[..., bool]) -> None:
    """An error of Numba's where an argument is no field of a record, or the shapes do not fit."""
    for kind in matrices:
        if not isinstance(kind, types.NestedArray) or kind.ndim != 2 or kind.dtype != types.float64:
            raise errors.TypingError(f"{name} takes matrices of doubles that are fields of records, not {kind}")
    if not fits(*(kind.shape for kind in matrices)):
        raise errors.TypingError(f"{name}: shapes do not fit: {[kind.shape for kind in matrices]}")


def _matrices(context: Any, builder: Any, signature: Any, values: Any) -> list[_Matrix]:
    return [_Matrix(context, builder, kind, value) for kind, value in zip(signature.args, values, strict=True)]


def _sums(builder: Any, right: _Matrix, rows: int, count: int, factors: Callable[[int], list[Any]]) -> list[list[Any]]:
    """Vectors of sum_k factor_k times row k of ``right``, for each of ``rows`` rows."""
    totals: list[list[Any]] = [[None] * len(right.blocks) for _ in range(rows)]
    for k in range(count):
        numbers = factors(k)
        for block, (column, width) in enumerate(right.blocks):
            vector = right.vector(_index(k), column, width)
            for row in range(rows):
                term = builder.fmul(_spread(builder, numbers[row], width), vector, flags=_FLAGS)
                total = totals[row][block]
                totals[row][block] = term if total is None else builder.fadd(total, term, flags=_FLAGS)
    return totals


def _product(name: str, sums: str) -> Any:
    """``multiply`` and its relatives: what becomes of the sums ("=", "+", "-")."""

    def kernel(typing: Any, a: Any, b: Any, target: Any) -> Any:
        _checked(name, (a, b, target), lambda s, t, u: s[0] >= u[0] and s[1] >= t[0] and t[1] == u[1])

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            left, right, out = _matrices(context, builder, signature, values)

            def some_rows(first: Any, rows: int) -> None:
                totals = _sums(
                    builder,
                    right,
                    rows,
                    right.rows,
                    lambda k: [left.number(first, row * left.columns + k) for row in range(rows)],
                )
                for row in range(rows):
                    for block, (column, width) in enumerate(out.blocks):
                        value, offset = totals[row][block], row * out.columns + column
                        if sums != "=":
                            old = out.vector(first, offset, width)
                            value = (builder.fadd if sums == "+" else builder.fsub)(old, value, flags=_FLAGS)
                        out.store(value, first, offset, width)

            _in_groups(builder, out.rows, max(1, min(4, SUMS // len(out.blocks))), some_rows)
            return context.get_dummy_value()

        return types.void(a, b, target), generate

    kernel.__name__ = kernel.__qualname__ = name
    return intrinsic(kernel)


def _in_groups(builder: Any, rows: int, together: int, some_rows: Callable[[Any, int], None]) -> None:
    """Call ``some_rows`` for groups of ``together`` rows in a loop, and once for the rest."""
    with cgutils.for_range(builder, _index(rows // together)) as loop:
        some_rows(builder.mul(loop.index, _index(together)), together)
    if rows % together:
        some_rows(_index(rows - rows % together), rows % together)


multiply = _product("multiply", "=")  # target (n, m) = the first k columns of a (n, >= k) times b (k, m)
add_product = _product("add_product", "+")  # target += a b
subtract_product = _product("subtract_product", "-")  # target -= a b


def _add_squares(typing: Any, rows: Any, target: Any) -> Any:
    """``target`` (m, m) += rows^T rows, of ``rows`` (n, m): its upper half, in blocks of ``WIDE``; see ``mirror``.

    Raises:
        TypingError: m is not a multiple of ``WIDE``.
    """
    _checked("add_squares", (rows, target), lambda s, t: t == (s[1], s[1]) and s[1] % WIDE == 0)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        source, out = _matrices(context, builder, signature, values)
        blocks = _index(out.columns // WIDE)
        with cgutils.for_range(builder, blocks) as upper, cgutils.for_range(builder, blocks, start=upper.index) as left:
            first, column = (builder.mul(loop.index, _index(WIDE)) for loop in (upper, left))
            together = WIDE if SUMS > WIDE else WIDE // 2
            for begin in range(0, WIDE, together):
                rows = range(begin, begin + together)
                totals: dict[int, Any] = {}
                for k in range(source.rows):
                    vector = source.vector(_index(k), column, WIDE)
                    for row in rows:
                        number = source.number(_index(k), builder.add(first, _index(row)))
                        term = builder.fmul(_spread(builder, number, WIDE), vector, flags=_FLAGS)
                        totals[row] = term if k == 0 else builder.fadd(totals[row], term, flags=_FLAGS)
                for row in rows:
                    here = builder.add(first, _index(row))
                    old = out.vector(here, column, WIDE)
                    out.store(builder.fadd(old, totals[row], flags=_FLAGS), here, column, WIDE)
        return context.get_dummy_value()

    return types.void(rows, target), generate


add_squares: Any = intrinsic(_add_squares)


@njit
def mirror(matrix):
    """The lower half becomes that of a symmetric matrix whose upper half is ``matrix``'s."""
    for i in range(matrix.shape[0]):
        for j in range(i):
            matrix[i, j] = matrix[j, i]


def _add_scaled(typing: Any, target: Any, start: Any, factor: Any, source: Any) -> Any:
    """``target`` = ``start`` + ``factor`` ``source`` for three matrices of one shape; ``start`` may be ``target``."""
    _checked("add_scaled", (target, start, source), lambda s, t, u: s == t == u)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kinds, arrays = signature.args, values
        out, first, second = (_Matrix(context, builder, kinds[i], arrays[i]) for i in (0, 1, 3))

        def some_row(row: Any, _: int) -> None:
            for column, width in out.blocks:
                term = builder.fmul(_spread(builder, arrays[2], width), second.vector(row, column, width), flags=_FLAGS)
                out.store(builder.fadd(first.vector(row, column, width), term, flags=_FLAGS), row, column, width)

        _in_groups(builder, out.rows, 1, some_row)
        return context.get_dummy_value()

    return types.void(target, start, types.float64, source), generate


add_scaled: Any = intrinsic(_add_scaled)


def _whiten(typing: Any, factor: Any, rows: Any) -> Any:
    """``rows`` (n, m) <- L^-1 ``rows``, with L the lower half of ``factor``, as ``decompose`` leaves it."""
    _checked("whiten", (factor, rows), lambda s, t: s == (t[0], t[0]))

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        lower, out = _matrices(context, builder, signature, values)
        for pair in range(0, len(out.blocks), 2):
            here = out.blocks[pair : pair + 2]
            done: list[list[Any]] = []
            for i in range(out.rows):
                vectors = [out.vector(_index(i), column, width) for column, width in here]
                for k in range(i):
                    share = lower.number(_index(i), k)
                    for block, (_, width) in enumerate(here):
                        term = builder.fmul(_spread(builder, share, width), done[k][block], flags=_FLAGS)
                        vectors[block] = builder.fsub(vectors[block], term, flags=_FLAGS)
                last = lower.number(_index(i), i)
                for block, (column, width) in enumerate(here):
                    vectors[block] = builder.fmul(vectors[block], _spread(builder, last, width), flags=_FLAGS)
                    out.store(vectors[block], _index(i), column, width)
                done.append(vectors)
        return context.get_dummy_value()

    return types.void(factor, rows), generate


whiten: Any = intrinsic(_whiten)


@njit
def decompose(matrix):
    """The lower half becomes the Cholesky factor L, the inverse of L's diagonal on the diagonal.

    False if the matrix is not positive definite.
    """
    size = matrix.shape[0]
    for j in range(size):
        for i in range(j, size):
            value = matrix[i, j]
            for k in range(j):
                value -= matrix[i, k] * matrix[j, k]
            if i > j:
                matrix[i, j] = value * matrix[j, j]
            elif value > 0.0:
                matrix[j, j] = 1.0 / sqrt(value)
            else:
                return False
    return True
