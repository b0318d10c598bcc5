"""Free motion of the jaw with two condyles: classical Runge-Kutta steps of the compiled equations."""

from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.runge_kutta import runge_kutta_step, set_state
from jawenv.mechanics.bilateral import bilateral_rate
from jawenv.mechanics.kinematics import split_body


@njit_within
def free_rate(q, u, stage, h, given):
    jaw, muscles, wrench = given
    return bilateral_rate(jaw, muscles, q, u, wrench)


@njit
def bilateral_step(jaw, muscles, state, wrench, h):
    """Move ``state`` (12) by one Runge-Kutta step of ``h`` seconds, at most ``BODY_STEP``, under a constant wrench."""
    q, u = split_body(state)
    q, u = runge_kutta_step(free_rate, q, u, h, (jaw, muscles, wrench))
    set_state(state, q, u)
