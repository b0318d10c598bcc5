"""F_o from a small opening, then b from a larger one through logarithms: the failed method of Young (2016), A.4.

Stage 1 takes the tension of a little strained muscle as the constant F_o (eqs. A.34-A.37), which makes d = H F_o a
linear system. Stage 2 takes logarithms of d = sum a_i F_oi exp(b_i e_i) (eq. A.38) to have b linear too. That is right
for one muscle,

    ln(d / (a F_o)) = b e,

and for no more: the logarithm of a sum is not the sum of logarithms. Eq. A.40 besides prints the product
ln(a_i F_oi) e_i where this difference of logarithms belongs, and d without its own logarithm. A component of d or a
may be negative; its logarithm is then complex, as in the thesis's MATLAB, and of the solution the real part is taken.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eval.thesis.methods.moment_balance import Balance, balance_of
from jawenv.recordings.record import Record

Array = NDArray[np.float64]
SMALL_SHARE = 0.2
"""Share of the record, its times of least strain, that is taken for the small opening."""


def two_stages(record: Record) -> Array:
    """(2 m,) natural logs of F_o and b; NaN for a muscle whose F_o or b came out at 0 or less.

    If one F_o is not positive, no b exists, since the logarithm of every F_o enters each. Of muscles with one line
    each, or lines that share a strain.
    """
    equations = balance_of(record, rows="moment")
    small = small_opening(equations, SMALL_SHARE)
    F_o = constant_forces(equations.select(small))
    logs = np.full(2 * equations.muscles, np.nan)
    logs[0::2] = _log_of_positive(F_o)
    if (F_o > 0.0).all():
        logs[1::2] = _log_of_positive(exponents(equations.select(~small), F_o))
    return logs


def _log_of_positive(values: Array) -> Array:
    return np.log(np.where(values > 0.0, values, np.nan))


def constant_forces(balance: Balance) -> Array:
    """Stage 1, eq. A.37: (m,) constant forces of the muscles (N), of either sign."""
    weighted = balance.whitened(balance.noise)
    matrix = weighted.sum_lines(weighted.pull).transpose(0, 2, 1).reshape(-1, balance.muscles)
    return np.asarray(np.linalg.lstsq(matrix, weighted.needed.ravel(), rcond=None)[0], dtype=np.float64)


def exponents(balance: Balance, F_o: Array) -> Array:
    """Stage 2: (m,) b of each muscle, of either sign, from the larger opening, with F_o (m,), N and positive.

    The sum of b_i e_i is taken for ln d less the sum of ln(a_i F_oi), which is exact for one muscle.
    """
    # log(0) of a row that a muscle does not reach is -inf and would be all of the solution.
    arms = balance.sum_lines(balance.pull).astype(np.complex128) + np.finfo(np.float64).tiny
    logs = np.log(arms * F_o[:, None])
    shape = (*balance.needed.shape, balance.muscles)
    matrix = np.broadcast_to(_mean_strain(balance)[:, None, :], shape).astype(np.complex128)
    right = np.log(balance.needed + np.finfo(np.float64).tiny + 0j) - logs.sum(axis=1)
    solution = np.linalg.lstsq(matrix.reshape(-1, balance.muscles), right.ravel(), rcond=None)[0]
    return np.asarray(solution.real, dtype=np.float64)


def _mean_strain(balance: Balance) -> Array:
    """(N, m) mean strain of the lines of each muscle."""
    lines = np.bincount(balance.muscle)
    total: Array = balance.sum_lines(balance.strain[:, :, None])[:, :, 0]
    return total / lines


def small_opening(balance: Balance, share: float) -> NDArray[np.bool_]:
    """(N,) which times belong to that share of all whose most strained line is strained least."""
    largest_strain = np.abs(balance.strain).max(axis=1)
    chosen: NDArray[np.bool_] = largest_strain <= np.quantile(largest_strain, share)
    return chosen
