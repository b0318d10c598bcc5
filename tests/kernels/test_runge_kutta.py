"""The classical Runge-Kutta step on equations whose solutions are known."""

import numpy as np
import pytest
from numba.core.errors import TypingError

from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.runge_kutta import plus, runge_kutta_step, set_state, stage_place


@njit_within
def driven_rate(q, u, stage, h, given):
    """Two oscillators of squared frequencies 1 and 4, the first pushed by cos(2 t)."""
    start, _ = given
    time = start + stage_place(stage) * h
    return u, (np.cos(2.0 * time) - q[0], -4.0 * q[1])


@njit
def driven(state, steps, seconds):
    h = seconds / steps
    for step in range(steps):
        q, u = (state[0], state[1]), (state[2], state[3])
        q, u = runge_kutta_step(driven_rate, q, u, h, (step * h, state))
        set_state(state, q, u)


def solution(t):
    """From (1, 1, 0, 0): x'' + x = cos(2 t), y'' + 4 y = 0."""
    x, x_rate = 4.0 / 3.0 * np.cos(t) - np.cos(2 * t) / 3.0, -4.0 / 3.0 * np.sin(t) + 2.0 / 3.0 * np.sin(2 * t)
    return np.array([x, np.cos(2 * t), x_rate, -2.0 * np.sin(2 * t)])


def error(steps, seconds=2.0):
    state = np.array([1.0, 1.0, 0.0, 0.0])
    driven(state, steps, seconds)
    return np.abs(state - solution(seconds)).max()


def test_half_the_step_has_a_sixteenth_of_the_error():
    for steps in (40, 80):
        assert error(steps) / error(2 * steps) == pytest.approx(16.0, rel=0.1)


@njit
def sums(a, factor, b, c, d):
    return plus(a, factor, b), plus(c, factor, d)


def test_tuples_of_any_length_are_added():
    assert sums((1.0,), 2.0, (3.0,), (1.0, 2.0, 3.0), (4.0, 5.0, 6.0)) == ((7.0,), (9.0, 12.0, 15.0))


def test_tuples_of_different_lengths_are_refused():
    with pytest.raises(TypingError, match="as many doubles"):
        sums((1.0,), 2.0, (3.0, 4.0), (1.0,), (1.0,))
