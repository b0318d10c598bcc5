"""Place and motion of the jaw from the pose of the mouthpiece: Young (2016), section 5.1, eqs. 5.1-5.3.

The mouthpiece is rigid with the mandible, so its place r_a, velocity and acceleration follow from the condyle's:

    r_a = r_* + C^T rho,    v_a = v_* + C^T (omega x rho),
    a_a = a_* + C^T (omega' x rho + omega x (omega x rho))

with C^T, body to head axes, where Young prints C, and v_*, a_* tangent to the fossa. With the three angles measured
beside r_a there are six numbers for five coordinates, and a unique solution without bounds; from r_a alone, as Young
has it, there is not (``point_kinematics``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import N_STATES
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import angle_rates, split

Array = NDArray[np.float64]
N_COORDINATES = 5
# Starting at the angles as measured, the second step is the last that changes anything beyond rounding.
STEPS = 4


@njit
def _fill_measurements(jaw: Jaw, states, expected, rows, rates):
    """The encoders' readings in each state: values (N, 12), derivatives (N, 12, 10) and rates of q (N, 5)."""
    for n in range(states.shape[0]):
        measure(jaw, states[n], rows[n], expected[n])
        q, u = split(states[n])
        turn = angle_rates(q, (u[2], u[3], u[4]))
        rates[n, 0], rates[n, 1] = u[0], u[1]
        for i in range(3):
            rates[n, 2 + i] = turn[i]


def expected_measurements(jaw: Any, states: Array) -> tuple[Array, Array, Array]:
    """The encoders' readings without noise.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        states: (N, 10) motion (q, u).

    Returns:
        (N, 12) readings, (N, 12, 10) their derivatives by the state, (N, 5) rates of q.
    """
    number = len(states)
    expected, rows = np.empty((number, N_MEASUREMENTS)), np.empty((number, N_MEASUREMENTS, N_STATES))
    rates = np.empty((number, N_COORDINATES))
    _fill_measurements(jaw, np.ascontiguousarray(states), expected, rows, rates)
    return expected, rows, rates


def motion_from_pose(jaw: Any, measured: Array, measurement_sd: Array, start_mean: Array, start_sd: Array) -> Array:
    """Motion at each of N times by weighted least squares, each time for itself.

    Twelve readings for ten unknowns. A coordinate that cannot move, ``start_sd`` 0, keeps its value and its speed.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        measured: (N, 12) encoders, all of them read.
        measurement_sd: (12,) their noise.
        start_mean: (10,) values of the coordinates that cannot move.
        start_sd: (10,) 0 for what cannot move.

    Returns:
        (N, 10) states (q, u).
    """
    if np.shape(start_mean) != (N_STATES,):
        raise InputError(f"start_mean has shape {np.shape(start_mean)}; allowed: ({N_STATES},): the midline model")
    free = np.asarray(start_sd) > 0.0
    states = np.tile(np.asarray(start_mean, dtype=np.float64), (len(measured), 1))
    guess = np.column_stack([measured[:, :2] - _arm(jaw, measured)[:, :2], measured[:, 3:6]])
    states[:, :N_COORDINATES][:, free[:N_COORDINATES]] = guess[:, free[:N_COORDINATES]]
    for _ in range(STEPS):
        expected, rows, _ = expected_measurements(jaw, states)
        whitened = rows[:, :, free] / measurement_sd[:, None]
        information = whitened.transpose(0, 2, 1) @ whitened
        score = np.einsum("nmi,nm->ni", whitened, (measured - expected) / measurement_sd)
        states[:, free] += np.linalg.solve(information, score[:, :, None])[:, :, 0]
    return states


def acceleration_from_mouthpiece(
    jaw: Any, states: Array, accelerations: Array, weights_sd: Array, free: NDArray[np.bool_]
) -> Array:
    """Accelerations u' from those of the mouthpiece, eq. 5.3 with C^T: the derivative of v_a = V(q) u.

    Args:
        jaw: Record from ``build_jaw`` of the midline model.
        states: (N, 10) motion.
        accelerations: (N, 6) of the mouthpiece in head axes (m/s2) and angular, body axes (rad/s2).
        weights_sd: (6,) their noise, up to a common factor.
        free: (5,) which of x', y', omega can change; the others get 0.

    Returns:
        (N, 5) x'', y'' (m/s2) and angular acceleration (rad/s2, body axes).
    """
    _, rows, rates = expected_measurements(jaw, states)
    by_speed, by_place = rows[:, 6:, N_COORDINATES:], rows[:, 6:, :N_COORDINATES]
    residual = (accelerations - np.einsum("nij,nj->ni", by_place, rates)) / weights_sd
    whitened = by_speed[:, :, free] / weights_sd[:, None]
    result = np.zeros((len(states), N_COORDINATES))
    information = whitened.transpose(0, 2, 1) @ whitened
    score = np.einsum("nmi,nm->ni", whitened, residual)
    result[:, free] = np.linalg.solve(information, score[:, :, None])[:, :, 0]
    return result


def _arm(jaw: Any, measured: Array) -> Array:
    """(N, 3) the mouthpiece from the contact point in head axes, by the measured angles."""
    origin = np.zeros((len(measured), N_STATES))
    origin[:, 2:5] = measured[:, 3:6]
    expected, _, _ = expected_measurements(jaw, origin)  # the condyle at the fossa's roof, which is the origin
    return expected[:, :3]
