"""How fast a jaw can swing on its muscles, and so into how many parts a step of an explicit method has to be divided.

The rate is an upper bound: with k_i = T_i b_i / l_o,i the stiffness of line i and w_i the mobility of a free mandible
along it, e^T (1/m + [r]x^T I^-1 [r]x) e, no mode is faster than sqrt(sum k_i w_i), as the largest eigenvalue of a sum
is at most the sum of the largest, and the fossa can only slow the body down.
"""

from __future__ import annotations

from math import sqrt

from jawenv.compiled import njit
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.kinematics import contact_point, rotation

LARGEST_PHASE = 2.5  # rad in one step: the classical Runge-Kutta method bears 2.78
MOST_PARTS = 16


@njit
def fastest_rate(jaw, muscles, q):
    """Bound on the angular frequency (rad/s) of the jaw's free motion at the pose q (five coordinates)."""
    contact, body_to_head = contact_point(jaw, q), rotation(q)
    total = 0.0
    for i in range(muscles.shape[0]):
        _, _, _, tension = muscle_pull(jaw, muscles, i, contact, body_to_head)
        total += tension * muscles[i, 1] / jaw.l_o[i] * jaw.mobility[i]
    return sqrt(total)


@njit
def parts_needed(rate, dt, fewest):
    """Into how many parts a step ``dt`` is divided: ``fewest``, doubled until each is short enough."""
    parts = fewest
    while rate * dt > LARGEST_PHASE * parts and parts < MOST_PARTS:
        parts *= 2
    return parts
