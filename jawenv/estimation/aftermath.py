"""What a covariance of regressors and error takes from the score from now on.

The ``aftermath`` M of a unit of T = cov(by_tension, e), with e the estimate's error, is what all coming readings take
from the score because of it. T becomes A T A^T in a step and (I - K H) T (I - K H)^T in an update, which takes
h T h^T / (innovation's variance) of each reading's row h from the score; M follows the transpose of these rules, from
the last reading back to the present. A filter does not know the coming ticks. It takes them for ticks like the past
ones, in their order: M of each tick *between two readings* of the encoders is what it was at the same distance
from the last reading one such time before. That matters where readings are seldom, for M rises from one to the next.
"""

from __future__ import annotations

from typing import Any

from jawenv.compiled import njit
from jawenv.estimation.measurement import N_MEASUREMENTS
from jawenv.estimation.products import multiply, transpose

# Ticks between two readings that are told apart; 40 of 5 ms are those of encoders at 5 Hz.
MOST_TICKS = 40


def aftermath_fields(n_states: int) -> list[Any]:
    """What is carried from tick to tick, as fields of a dtype.

    ``aftermath`` is M at the end of the present tick, before its readings; ``ahead`` that of each tick after a reading,
    ``ahead_of`` their number; ``steps`` the motion's derivatives A since the last reading, ``since`` their number.
    """
    ticks = (MOST_TICKS, n_states, n_states)
    return [
        ("aftermath", "f8", (n_states, n_states)),
        ("ahead", "f8", ticks),
        ("ahead_of", "i8"),
        ("steps", "f8", ticks),
        ("since", "i8"),
    ]


@njit
def forget_aftermath(belief):
    """Nothing has been read yet."""
    belief.aftermath[:, :] = 0.0
    belief.ahead_of, belief.since = 0, 0


@njit
def limit_aftermath(aftermath, predicted_cov):
    """Scale M so that trace(M P) <= n: it is at most P^-1, which is all that innovations can ever say of e.

    In the order of time the rules for M need not shrink it where P changes suddenly, as where readings are lost.
    """
    size, told = aftermath.shape[0], 0.0
    for i in range(size):
        for j in range(size):
            told += aftermath[i, j] * predicted_cov[i, j]
    if told > size:
        share = size / told
        for i in range(size):
            for j in range(size):
                aftermath[i, j] *= share


@njit
def look_ahead(belief, total):
    """M of one more tick without a reading, whose step has the derivative ``total`` (n, n and more columns)."""
    size = belief.aftermath.shape[0]
    belief.since += 1
    if belief.ahead_of > 0:
        belief.aftermath[:, :] = belief.ahead[min(belief.since, belief.ahead_of) - 1]
    step = belief.steps[min(belief.since, MOST_TICKS) - 1]
    if belief.since <= MOST_TICKS:
        for i in range(size):
            for j in range(size):
                step[i, j] = total[i, j]
    else:
        # One long step; M is told apart no further.
        multiply(total, step.copy(), step)
    limit_aftermath(belief.aftermath, belief.motion_cov)


@njit
def carry_back(aftermath, step, scratch):
    """M <- A^T M A."""
    transpose(step, scratch.halfway)
    multiply(aftermath, step, scratch.crossed)
    multiply(scratch.halfway, scratch.crossed, aftermath)


@njit
def update_aftermath(aftermath, rows, gains, weights, spare):
    """M <- (I - k h)^T M (I - k h) + h h^T / S for every reading, the last first; ``gains`` are k, ``weights`` 1/S.

    A reading that was not used has the weight zero.
    """
    size = aftermath.shape[0]
    for i in range(N_MEASUREMENTS - 1, -1, -1):
        if weights[i] == 0.0:
            continue
        squared = weights[i]
        for j in range(size):
            value = 0.0
            for k in range(size):
                value += aftermath[j, k] * gains[i, k]
            spare[j] = value
            squared += value * gains[i, j]
        for j in range(size):
            factor = squared * rows[i, j] - spare[j]
            for k in range(size):
                aftermath[j, k] += factor * rows[i, k] - rows[i, j] * spare[k]


@njit
def end_reading(belief, scratch):
    """After readings: M before them, and in the ticks before, as if the coming ticks were like those since the last.

    Takes ``rows``, ``gains`` and ``weights`` of the readings; overwrites ``crossed`` and ``halfway``.
    """
    steps = min(belief.since, MOST_TICKS)
    aftermath, ahead = belief.aftermath, belief.ahead
    for k in range(steps - 1, -1, -1):
        carry_back(aftermath, belief.steps[k], scratch)
    update_aftermath(aftermath, scratch.rows, scratch.gains, scratch.weights, scratch.spare)
    last = max(steps, 1) - 1
    ahead[last] = aftermath
    for k in range(last - 1, -1, -1):
        ahead[k] = ahead[k + 1]
        carry_back(ahead[k], belief.steps[k + 1], scratch)
    belief.ahead_of, belief.since = last + 1, 0
