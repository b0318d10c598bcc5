"""Rest of the relaxed jaw, and its path when the mouth is opened slowly.

The equilibrium is found by pseudo-transient continuation (Kelley & Keyes 1998): implicit Euler steps along
q' = M^-1 Q(q) with growing step, which follow the branch that starts at the closed jaw and end at stable equilibria
only. Under a vertical force alone the branch folds (the condyle runs over the crest of the eminence), so the
mouth is opened by a stiff vertical spring whose end is moved, and the force is read from the spring.
"""

from __future__ import annotations

import numpy as np

from jawenv.kernels.cholesky import solve_in_place
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, vector3
from jawenv.mechanics.dynamics import N_WRENCH, REST_TOLERANCE, Linear, linearise_acceleration
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, rotation, turning_axes

MAX_ITERATIONS = 300
HOLD_STIFFNESS = 20e3  # N/m


@njit
def settle(jaw: Jaw, muscles, pose, opening, on_spring, linear: Linear, matrix, right):
    """Move ``pose`` (5) to equilibrium; returns the downward force (N) on the mouthpiece and whether it converged.

    With ``on_spring`` the mouthpiece hangs on a vertical spring whose end is ``opening`` (m) below the closed jaw;
    otherwise it is free. ``linear`` (``Linear``), ``matrix`` (5, 5) and ``right`` (5) are working
    memory.
    """
    step = 1e-4
    previous = np.inf
    force = 0.0
    arm = vector3(jaw.mouthpiece)
    for _ in range(MAX_ITERATIONS):
        q = (pose[0], pose[1], pose[2], pose[3], pose[4])
        body_to_head = rotation(q)
        position = add(contact_point(jaw, q), apply(body_to_head, arm))
        spring_stiffness = HOLD_STIFFNESS if on_spring else 0.0
        force = spring_stiffness * (opening - (jaw.mouthpiece[2] - position[2]))
        down = apply_transposed(body_to_head, (0.0, 0.0, -1.0))
        wrench = (force * down[0], force * down[1], force * down[2], 0.0, 0.0, 0.0)
        no_speeds = (0.0, 0.0, 0.0, 0.0, 0.0)
        rate = linearise_acceleration(jaw, muscles, q, no_speeds, wrench, linear)
        residual = max(abs(rate[0]), abs(rate[1]), abs(rate[2]), abs(rate[3]), abs(rate[4]))
        if residual < REST_TOLERANCE:
            return force, True
        step = min(step * min(max(previous / residual, 0.5), 3.0), 1e6)
        previous = residual
        fill_flow_matrix(jaw, q, body_to_head, down, spring_stiffness, force, linear, matrix)
        axes = turning_axes(q)
        for i in range(5):
            right[i] = rate[i]
            for j in range(5):
                matrix[i, j] = -matrix[i, j]
        # Rows 2-4 are in body axes; the step is in angles: omega = sum of rate times axis.
        matrix[0, 0] += 1.0 / step
        matrix[1, 1] += 1.0 / step
        for i in range(3):
            for j in range(3):
                matrix[2 + i, 2 + j] += axes[j][i] / step
        solve_in_place(matrix, right)
        if not jaw.free_x:
            right[0] = 0.0
        if not jaw.free_y:
            right[1] = 0.0
        largest = max(abs(right[0]), abs(right[1])) / 2e-3
        largest = max(largest, max(abs(right[2]), max(abs(right[3]), abs(right[4]))) / 0.1)
        scaling = 1.0 / max(1.0, largest)
        for i in range(5):
            pose[i] += scaling * right[i]
    return force, False


@njit
def fill_flow_matrix(jaw: Jaw, q, body_to_head, down, spring_stiffness, force, linear: Linear, matrix):
    """Derivative of u' by q (5 x 5) with the spring's force following the motion."""
    arm = vector3(jaw.mouthpiece)
    slope = -jaw.fossa_drop * jaw.fossa_frequency * np.sin(jaw.fossa_frequency * q[0])
    axes = turning_axes(q)
    wrench_column = linear.by_input.shape[1] - N_WRENCH
    for j in range(5):
        turn = (0.0, 0.0, 0.0)
        if j == 0:
            drop = -slope
        elif j == 1:
            drop = 0.0
        else:
            drop = -apply(body_to_head, cross(axes[j - 2], arm))[2]
            turn = cross(axes[j - 2], down)
        for i in range(5):
            value = linear.by_state[i, j]
            for k in range(3):
                value += linear.by_input[i, wrench_column + k] * (-spring_stiffness * drop * down[k] - force * turn[k])
            matrix[i, j] = value
