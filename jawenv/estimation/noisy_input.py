"""What the load cell's noise does to an estimate that takes its readings for the force, and how the score is rid of it.

The filter moves its jaw by the reading z = F + n. The noise n then moves the estimated motion, and with it the tensions
that the filter expects there: the regressor and the next innovation share n. Where the force hardly changes, and so
all that tells of the stiffness is how the jaw trembles, least squares would be biased by more than its sd: the
regression with errors in its variables. A device whose force answers to the true motion, by a stiff position servo or a
brake, makes it worse. The cure is the corrected score (Nakamura 1990, Biometrika 77:127; Soderstrom 2007, Automatica
43:939): subtract the expectation that both give it.

With e = estimated less true motion, P its covariance, A and G the step's derivative by motion and wrench, K the gain,
N the variance of n and W_u that of the unmodelled wrench:

* ``tremble`` C = -cov(true motion, e). It becomes C (I - K H)^T in an update. In a step it becomes A C A^T + G W_u G^T;
  where the device answers, the first A and the first G are those of the closed loop (``closed_loop``). Without n and
  answer C equals P: that an estimate is uncorrelated with its error is what makes the filter optimal. D = P - C is the
  covariance of estimated motion and e.
* ``aftermath`` M: what a unit of cov(by_tension, e) takes from the score from now on (in the file of that name).

A line with the tension exp(b_k e) makes cov(by_tension, e) grow by G d(w exp(b_k e))/dq D, with w its unit wrench; the
load cell's gain error, where it multiplies the reading itself, by G cov(z, e) = G N G^T. Nothing answers there, and F
and e share nothing.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

from jawenv.compiled import njit
from jawenv.estimation.closed_loop import ARM, closed_loop_fields, set_loop
from jawenv.estimation.measurement import N_MEASUREMENTS
from jawenv.estimation.products import multiply
from jawenv.mechanics.dynamics import N_WRENCH

LARGEST_TREMBLE = 5e-4  # m, sd; ten times what an estimate owes to its errors wherever a straight line describes it


def noisy_input_fields(n_states: int) -> list[Any]:
    """Working memory of this file as fields of a dtype."""
    square = (n_states, n_states)
    return [
        *closed_loop_fields(n_states),
        ("crossed", "f8", square),
        ("halfway", "f8", square),
        ("spilt", "f8", (N_WRENCH, n_states)),
        ("gains", "f8", (N_MEASUREMENTS, n_states)),
        ("weights", "f8", N_MEASUREMENTS),
    ]


@njit
def limit_tremble(tremble, covariance):
    """Scale D = P - C so that no coordinate of the estimate needs a larger sd than ``LARGEST_TREMBLE`` to have it.

    Where a jaw is unstable, as one with two condyles of which one rides over the crest, straight lines let the true
    motion's deviations grow by half in every tick, and C with them; the true jaw falls off, and stays near.
    """
    half = tremble.shape[0] // 2
    share = 1.0
    for i in range(half):
        sd = LARGEST_TREMBLE if i < half - 3 else LARGEST_TREMBLE / ARM
        shared, most = abs(covariance[i, i] - tremble[i, i]), sd * sqrt(covariance[i, i])
        if share * shared > most:
            share = most / shared
    if share < 1.0:
        for i in range(tremble.shape[0]):
            for j in range(tremble.shape[0]):
                tremble[i, j] = covariance[i, j] - share * (covariance[i, j] - tremble[i, j])


@njit
def carry(tremble, answer, wrench, noise_variance, scratch):
    """C <- B C A^T + H W_u G^T, with [B, ..., H] the columns of ``answer``, H those from ``wrench`` on."""
    turned = scratch.turned
    size = tremble.shape[0]
    multiply(answer, scratch.crossed, tremble)
    for i in range(size):
        for k in range(N_WRENCH):
            factor = answer[i, wrench + k] * (noise_variance[k] - noise_variance[N_WRENCH + k])
            for j in range(size):
                tremble[i, j] += factor * turned[size + 1 + k, j]


@njit
def predict_tremble(tremble, predicted_cov, noise_variance, answers, dt, scratch):
    """Carry C over a step of which ``turned`` holds the transposed derivative.

    Leaves half way D in ``halfway``. ``moved_cov`` holds A P, with P that of the step's start; ``predicted_cov`` is
    that of its end.
    """
    total, crossed, halfway = scratch.total, scratch.crossed, scratch.halfway
    size = tremble.shape[0]
    multiply(tremble, scratch.turned, crossed)
    if answers:
        set_loop(dt, scratch)
        carry(tremble, scratch.loop, size, noise_variance, scratch)
    else:
        carry(tremble, total, size + 1, noise_variance, scratch)
    for i in range(size):
        for j in range(size):
            start = scratch.moved_cov[j, i] - crossed[i, j]
            halfway[i, j] = 0.5 * (start + predicted_cov[i, j] - tremble[i, j])


@njit
def set_spilt(aftermath, noise_variance, by_reading, score, information, scratch):
    """What this step's errors take from the score; that about the load cell's gain where it multiplies the reading.

    Leaves in ``spilt`` (6, n) what a unit of w (de/dq) adds to the score.
    """
    total, crossed, spilt = scratch.total, scratch.crossed, scratch.spilt
    size, last = aftermath.shape[0], score.shape[0] - 1
    wrench = size + 1
    for k in range(N_WRENCH):
        for i in range(size):
            value = 0.0
            for j in range(size):
                value += aftermath[i, j] * total[j, wrench + k]
            crossed[i, k] = value
    for k in range(N_WRENCH):
        for j in range(size):
            value = 0.0
            for i in range(size):
                value += crossed[i, k] * scratch.halfway[j, i]
            spilt[k, j] = value
            if not by_reading:
                continue
            taken = crossed[j, k] * noise_variance[N_WRENCH + k] * total[j, wrench + k]
            score[last] += taken
            information[last, last] -= taken


@njit
def update_tremble(tremble, row, gain, inverse, spare):
    """C <- C (I - k h)^T for one reading; ``gain`` is P h, ``inverse`` that of the innovation's variance."""
    size = gain.shape[0]
    for i in range(size):
        value = 0.0
        for k in range(size):
            value += tremble[i, k] * row[k]
        spare[i] = value * inverse
    for i in range(size):
        for j in range(size):
            tremble[i, j] -= spare[i] * gain[j]
