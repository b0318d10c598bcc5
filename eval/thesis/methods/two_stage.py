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

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from eval.thesis.methods.moment_balance import SMOOTHING_S, Balance, Rows, balance_of
from eval.thesis.methods.regression import regression_covariance, scaled_inverse
from jawenv.base.errors import InputError
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record

Array = NDArray[np.float64]
NUDGE = 1e-5  # of ln F_o, for the derivative of stage 2 by it


@dataclass(frozen=True)
class TwoStageLogLinear:
    """The method of Young (2016), section A.4, of muscles with one line each or lines that share a strain."""

    form: Literal["difference", "product"] = "difference"
    """``difference``: sum of b_i e_i = ln d - sum of ln(a_i F_oi), exact for one muscle with F_o known; ``product``:
    eq. A.40 to the letter.
    """
    small_share: float = 0.2  # share of the record, its times of least strain, that is taken for the small opening
    rows: Rows = "moment"  # of the balance: the three moments (Young) or all five
    smoothing_s: float = SMOOTHING_S  # window of the balance's smoothing (s)
    name: str = "two-stage log-linear"

    def __post_init__(self) -> None:
        """Check the form and the share."""
        if self.form not in ("difference", "product"):
            raise InputError(f"form is {self.form!r}; allowed: 'difference', 'product'")
        if not 0.0 < self.small_share < 1.0:
            raise InputError(f"small_share is {self.small_share}; allowed: numbers above 0 and below 1")

    def estimate(self, record: Record) -> Estimate:
        """Mean and covariance of the logs; NaN for a muscle whose F_o or b came out at 0 or less.

        If one F_o is not positive, no b exists, since the logarithm of every F_o enters each.
        """
        equations = balance_of(record, rows=self.rows, smoothing_s=self.smoothing_s)
        muscles = equations.muscles
        small = small_opening(equations, self.small_share)
        F_o, F_o_covariance = constant_forces(equations.select(small), record.gain_sd)
        mean, covariance = np.full(2 * muscles, np.nan), np.full((2 * muscles, 2 * muscles), np.nan)
        determined = np.zeros(2 * muscles, dtype=np.bool_)
        joint_covariance = np.zeros_like(covariance)
        positive = F_o > 0.0
        by_log = np.where(positive, 1.0 / np.where(positive, F_o, 1.0), 0.0)
        log_covariance = F_o_covariance * np.outer(by_log, by_log)
        mean[0::2][positive], determined[0::2] = np.log(F_o[positive]), positive
        joint_covariance[0::2, 0::2] = log_covariance
        if positive.all():
            large = equations.select(~small)
            b, b_covariance = self.exponents(large, F_o)
            steps = np.exp(NUDGE * np.eye(muscles))
            by_log_F_o = np.stack([(self.exponents(large, F_o * step)[0] - b) / NUDGE for step in steps], axis=1)
            b_positive = b > 0.0
            by_log_b = np.where(b_positive, 1.0 / np.where(b_positive, b, 1.0), 0.0)
            chain = by_log_b[:, None] * by_log_F_o
            mean[1::2][b_positive], determined[1::2] = np.log(b[b_positive]), b_positive
            joint_covariance[1::2, 1::2] = (
                b_covariance * np.outer(by_log_b, by_log_b) + chain @ log_covariance @ chain.T
            )
            joint_covariance[1::2, 0::2] = chain @ log_covariance
            joint_covariance[0::2, 1::2] = joint_covariance[1::2, 0::2].T
        covariance[np.ix_(determined, determined)] = joint_covariance[np.ix_(determined, determined)]
        return Estimate(f"{self.name}, {self.form}", record.time[-1:], mean[None], covariance[None])

    def exponents(self, balance: Balance, F_o: Array) -> tuple[Array, Array]:
        """Stage 2: (m,) b of each muscle, of either sign, with F_o (m,) given, and its covariance.

        Args:
            balance: of the larger opening.
            F_o: (m,) N, positive.
        """
        strain = _mean_strain(balance)
        # log(0) of a row that a muscle does not reach is -inf and would be all of the solution.
        arms = balance.sum_lines(balance.pull).astype(np.complex128) + np.finfo(np.float64).tiny
        logs = np.log(arms * F_o[:, None])
        if self.form == "product":
            matrix, right = (logs * strain[:, :, None]).transpose(0, 2, 1), balance.needed.astype(np.complex128)
        else:
            shape = (*balance.needed.shape, balance.muscles)
            matrix = np.broadcast_to(strain[:, None, :], shape).astype(np.complex128)
            right = np.log(balance.needed + np.finfo(np.float64).tiny + 0j) - logs.sum(axis=1)
        flat = matrix.reshape(-1, balance.muscles)
        solution = np.asarray(np.linalg.lstsq(flat, right.ravel(), rcond=None)[0].real, dtype=np.float64)
        residual = right - np.einsum("nrm,m->nr", matrix, solution)
        noise = np.mean(np.abs(residual) ** 2)
        return solution, noise * scaled_inverse((flat.conj().T @ flat).real)


def constant_forces(balance: Balance, gain_sd: float) -> tuple[Array, Array]:
    """Stage 1, eq. A.37: (m,) constant forces of the muscles (N), of either sign, and their covariance."""
    weighted = balance.whitened(balance.noise)
    jacobian = weighted.sum_lines(weighted.pull).transpose(0, 2, 1)
    flat, right = jacobian.reshape(-1, balance.muscles), weighted.needed.ravel()
    solution = np.asarray(np.linalg.lstsq(flat, right, rcond=None)[0], dtype=np.float64)
    residual = (right - flat @ solution).reshape(weighted.needed.shape)
    return solution, regression_covariance(jacobian, residual, weighted.by_gain, gain_sd)


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
