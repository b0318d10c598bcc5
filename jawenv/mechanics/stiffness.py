"""Bound on the jaw's natural frequency, and the number of parts of a step of an explicit method.

The rate is an upper bound: with k_i the stiffness of line i, T_i b_i / l_o,i, or of a tooth or a stop that is touched,
and w_i the mobility of a free mandible along it, e^T (1/m + [r]x^T I^-1 [r]x) e, no mode is faster than
sqrt(sum k_i w_i), as the largest eigenvalue of a sum is at most the sum of the largest, and the fossa can only slow the
body down.
"""

from __future__ import annotations

from math import ceil, sqrt

from jawenv.kernels.compiled import njit
from jawenv.kernels.lanes import all_lines, total
from jawenv.kernels.vec3 import apply, row3
from jawenv.mechanics.forces import muscle_pull, smooth_ramp
from jawenv.mechanics.jaw import N_TEETH, Jaw
from jawenv.mechanics.kinematics import contact_point, rotation

# Longest phase (rad) of the bound in one step of the classical Runge-Kutta method. Stability would bear 2.78. A phase
# error acts as an error of the stiffness: at a phase of 2, a jaw on its teeth biases the estimated muscle forces.
LARGEST_PHASE = 1.5
MOST_PARTS = 16


@njit
def _touched_stiffness(jaw: Jaw, contact, body_to_head):
    """Sum of stiffness times mobility (1/s2) of the teeth and of the condyles' stops, as far as they are touched."""
    total = 0.0
    for i in range(N_TEETH):
        arm = apply(body_to_head, row3(jaw.teeth, i))
        _, steepness = smooth_ramp(contact[2] + arm[2] - jaw.teeth[i, 2], jaw.stop_width)
        total += jaw.tooth_stiffness * steepness * jaw.tooth_mobility[i]
    _, back = smooth_ramp(-contact[0], jaw.stop_width)
    _, front = smooth_ramp(contact[0] - jaw.crest, jaw.stop_width)
    return total + jaw.condyle_stiffness * (back + front) * jaw.condyle_mobility


@njit
def fastest_rate(jaw: Jaw, muscles, q):
    """Bound on the angular frequency (rad/s) of the jaw's free motion at the pose q (five coordinates)."""
    contact, body_to_head = contact_point(jaw, q), rotation(q)
    lines = all_lines(jaw.l_o)
    _, _, _, tension = muscle_pull(jaw, muscles, lines, contact, body_to_head)
    stretched = total(tension * muscles[lines, 1] / jaw.l_o[lines] * jaw.mobility[lines])
    return sqrt(_touched_stiffness(jaw, contact, body_to_head) + stretched)


@njit
def parts_needed(rate, dt, fewest):
    """Into how many parts a step ``dt`` is divided: ``fewest``, or more until each is short enough."""
    if not rate * dt < LARGEST_PHASE * MOST_PARTS:
        return MOST_PARTS
    return max(fewest, int(ceil(rate * dt / LARGEST_PHASE)))
