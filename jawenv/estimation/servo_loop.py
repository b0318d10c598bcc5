"""One step of the true motion's deviations while a position servo holds the jaw: what load cell and filter cannot see.

A servo swings the jaw within a step, and so the step is resolved: the exponential of the loop's matrix, by the Taylor
polynomial of degree four of a quarter step, squared twice.
"""

from __future__ import annotations

from typing import Any

from jawenv.compiled import njit
from jawenv.mechanics.dynamics import N_WRENCH

SQUARINGS = 2  # of a step's 2**-SQUARINGS-th part; a motor's servo swings by about 2 rad in 10 ms
DEGREE = 4


def servo_loop_fields(n_states: int) -> list[Any]:
    """Working memory of this file as fields of a dtype."""
    wide = (n_states, n_states + N_WRENCH)
    return [("rates", "f8", wide), ("loop", "f8", wide), ("power", "f8", wide), ("multiplied", "f8", wide)]


@njit
def set_rates(scratch):
    """Into ``rates`` (n, n + 6) the derivative of the state's rate by state and unmodelled wrench, servo included.

    From the last stage of ``propagate``.
    """
    rates, by_state, by_input, by_angle = scratch.rates, scratch.by_state, scratch.by_input, scratch.by_angle
    size = rates.shape[0]
    half = size // 2
    first, inputs = half - 3, by_input.shape[1] - N_WRENCH
    rates[:, :] = 0.0
    for i in range(first):
        rates[i, half + i] = 1.0
    for i in range(3):
        rates[first + i, first + 1], rates[first + i, first + 2] = by_angle[i, 0], by_angle[i, 1]
        for j in range(3):
            rates[first + i, half + first + j] = by_angle[i, 2 + j]
    for i in range(half):
        for k in range(N_WRENCH):
            rates[half + i, size + k] = by_input[i, inputs + k]
        for j in range(size):
            value = by_state[i, j]
            for k in range(N_WRENCH):
                value -= by_input[i, inputs + k] * scratch.servo[k, j]
            rates[half + i, j] = value


@njit
def multiply(left, right, product):
    """Product (n, m) of the first n columns of ``left`` and ``right`` (n, m)."""
    size, columns = product.shape
    for i in range(size):
        for j in range(columns):
            product[i, j] = 0.0
        for k in range(size):
            factor = left[i, k]
            if factor != 0.0:
                for j in range(columns):
                    product[i, j] += factor * right[k, j]


@njit
def set_loop(dt, scratch):
    """Into ``loop`` (n, n + 6) the derivative of the state after ``dt`` by state and unmodelled wrench at its start."""
    set_rates(scratch)
    rates, loop, power, multiplied = scratch.rates, scratch.loop, scratch.power, scratch.multiplied
    size, columns = loop.shape
    part = dt / 2.0**SQUARINGS
    for i in range(size):
        for j in range(columns):
            rates[i, j] *= part
            power[i, j] = rates[i, j]
            loop[i, j] = rates[i, j]
        loop[i, i] += 1.0
    for degree in range(2, DEGREE + 1):
        multiply(rates, power, multiplied)
        for i in range(size):
            for j in range(columns):
                power[i, j] = multiplied[i, j] / degree
                loop[i, j] += power[i, j]
    for _ in range(SQUARINGS):
        # [A, B] twice: [A A, A B + B].
        multiply(loop, loop, multiplied)
        for i in range(size):
            for j in range(columns):
                loop[i, j] = multiplied[i, j] + (loop[i, j] if j >= size else 0.0)
