"""Free motion of the jaw with two condyles: classical Runge-Kutta steps of the compiled equations."""

from jawenv.kernels.compiled import njit
from jawenv.mechanics.bilateral import bilateral_rate, plus_six, split_body


@njit
def bilateral_step(jaw, muscles, state, wrench, h):
    """Move ``state`` (12) by one Runge-Kutta step of ``h`` seconds, at most ``BODY_STEP``, under a constant wrench."""
    start_q, start_u = split_body(state)
    q, u = start_q, start_u
    sum_q, sum_u = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for stage in range(4):
        q_rate, u_rate = bilateral_rate(jaw, muscles, q, u, wrench)
        weight = h / 3.0 if stage == 1 or stage == 2 else h / 6.0
        sum_q, sum_u = plus_six(sum_q, weight, q_rate), plus_six(sum_u, weight, u_rate)
        reach = h if stage == 2 else 0.5 * h
        q, u = plus_six(start_q, reach, q_rate), plus_six(start_u, reach, u_rate)
    for i in range(6):
        state[i] = start_q[i] + sum_q[i]
        state[6 + i] = start_u[i] + sum_u[i]
