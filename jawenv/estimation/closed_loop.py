"""One step of the true motion's deviations while the device answers to them: what load cell and filter cannot see.

A position servo swings the jaw within a step, and so the step is resolved: the exponential of the loop's matrix, by the
Taylor polynomial of degree four of a short part of the step, squared until it is whole: of a quarter, for the jaw that
hangs open; of less where the teeth or the discs of two condyles make it stiff.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from jawenv.compiled import njit
from jawenv.estimation.products import multiply
from jawenv.mechanics.dynamics import N_WRENCH

LONGEST_PHASE = 2.0  # rad in a part, of a bound that is about three times what the servo swings by
MOST_SQUARINGS = 10
DEGREE = 4
ARM = 0.1  # m: an angle counts as much as what it moves at this arm


def closed_loop_fields(n_states: int) -> list[Any]:
    """Working memory of this file as fields of a dtype."""
    wide = (n_states, n_states + N_WRENCH)
    return [("rates", "f8", wide), ("loop", "f8", wide), ("power", "f8", wide), ("multiplied", "f8", wide)]


@njit
def set_rates(scratch):
    """Into ``rates`` (n, n + 6) the derivative of the state's rate by state and unmodelled wrench.

    From the last stage of ``propagate``, and the device's answer.
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
                value -= by_input[i, inputs + k] * scratch.answer[k, j]
            rates[half + i, j] = value


@njit
def squarings_needed(rates, dt):
    """How often to halve ``dt`` so that no motion turns by more than ``LONGEST_PHASE`` in a part.

    With x'' = K x + D x' no eigenvalue is larger than |D| + sqrt(|K|).
    """
    half = rates.shape[0] // 2
    stiffness, damping = 0.0, 0.0
    for i in range(half):
        for j in range(half):
            share = (1.0 if i < half - 3 else ARM) / (1.0 if j < half - 3 else ARM)
            stiffness += (share * rates[half + i, j]) ** 2
            damping += (share * rates[half + i, half + j]) ** 2
    phase = (sqrt(damping) + sqrt(sqrt(stiffness))) * dt
    squarings = 0
    while phase > LONGEST_PHASE and squarings < MOST_SQUARINGS:
        phase *= 0.5
        squarings += 1
    return squarings


@njit
def set_loop(dt, scratch):
    """Into ``loop`` (n, n + 6) the derivative of the state after ``dt`` by state and unmodelled wrench at its start."""
    set_rates(scratch)
    rates, loop, power, multiplied = scratch.rates, scratch.loop, scratch.power, scratch.multiplied
    size, columns = loop.shape
    squarings = squarings_needed(rates, dt)
    part = dt / 2.0**squarings
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
    for _ in range(squarings):
        # [A, B] twice: [A A, A B + B].
        multiply(loop, loop, multiplied)
        for i in range(size):
            for j in range(columns):
                loop[i, j] = multiplied[i, j] + (loop[i, j] if j >= size else 0.0)
