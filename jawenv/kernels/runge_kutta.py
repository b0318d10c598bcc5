"""The classical Runge-Kutta method of order four: its tableau, and a step of coordinates and speeds.

Stage 0 lies at the start of a step, stages 1 and 2 at its middle, stage 3 at its end. Each begins at the start, moved
by the last stage's rate over its reach; the step is the weighted sum of the four rates (Hairer, Norsett & Wanner 1993,
section II.1).
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import errors
from numba.extending import intrinsic

from jawenv.kernels.compiled import njit_inlined, njit_within

STAGES = 4


@njit_inlined
def stage_place(stage):
    """Place of a stage in a step, from 0 to 1."""
    return 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)


@njit_inlined
def stage_weight(stage, h):
    """The stage's share of a step of ``h`` seconds (s)."""
    return h / 3.0 if stage == 1 or stage == 2 else h / 6.0


@njit_inlined
def stage_reach(stage, h):
    """Reach of the next stage from the start along this stage's rate (s)."""
    return h if stage == 2 else 0.5 * h


def _plus(typing: Any, a: Any, factor: Any, b: Any) -> Any:
    """``a`` + ``factor`` ``b`` for two tuples of as many numbers."""
    if not isinstance(a, types.UniTuple) or a != b or a.dtype != types.float64:
        raise errors.TypingError(f"plus takes two tuples of as many doubles, not {a} and {b}")

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        first, number, second = values
        total = ir.Constant(first.type, ir.Undefined)
        for index in range(a.count):
            term = builder.fmul(number, builder.extract_value(second, index))
            value = builder.fadd(builder.extract_value(first, index), term)
            total = builder.insert_value(total, value, index)
        return total

    return a(a, types.float64, b), generate


plus: Any = intrinsic(_plus)


def _zeros(typing: Any, a: Any) -> Any:
    """A tuple of as many zeros as ``a`` has numbers."""
    return a(a), lambda context, builder, signature, values: context.get_constant_null(a)


zeros: Any = intrinsic(_zeros)


@njit_within
def runge_kutta_step(rate, q, u, h, arguments):
    """Coordinates and speeds after a step of ``h`` seconds.

    Becomes part of its caller's code, so that ``rate`` is a kernel known at compile time.

    Args:
        rate: Kernel of (q, u, stage, h, arguments) that returns (q', u').
        q: Tuple of coordinates.
        u: Tuple of speeds, of any length.
        h: s.
        arguments: Tuple of the rate's other inputs and of its memory.
    """
    start_q, start_u = q, u
    sum_q, sum_u = zeros(q), zeros(u)
    for stage in range(STAGES):
        q_rate, u_rate = rate(q, u, stage, h, arguments)
        weight, reach = stage_weight(stage, h), stage_reach(stage, h)
        sum_q, sum_u = plus(sum_q, weight, q_rate), plus(sum_u, weight, u_rate)
        q, u = plus(start_q, reach, q_rate), plus(start_u, reach, u_rate)
    return plus(start_q, 1.0, sum_q), plus(start_u, 1.0, sum_u)


@njit_inlined
def set_state(state, q, u):
    """Write coordinates and speeds into ``state``, one after the other."""
    for i in range(len(q)):
        state[i] = q[i]
        state[len(q) + i] = u[i]
