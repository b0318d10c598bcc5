"""Batch estimates from the balance of moments: linearised (Young 2016, section 5.2) and as it is (section 5.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from eval.thesis.methods.moment_balance import SMOOTHING_S, Balance, Rows, balance_of
from eval.thesis.methods.regression import regression_covariance
from jawenv.base.errors import InputError
from jawenv.recordings.estimate import Estimate
from jawenv.recordings.record import Record

Array = NDArray[np.float64]
REACH = 5.0  # prior sds to either side of the prior's mean: the bounds of the search, and the filter's


@dataclass(frozen=True)
class LinearLeastSquares:
    """Least squares on the muscle law expanded at strain 0, F = F_o (1 + b e): Young (2016), eqs. 5.6-5.10.

    Linear in F_o and F_o b, so a pseudo-inverse solves it; and wrong, for at b = 8 a strain of 0.3 gives 3.4 F_o where
    the law gives 11.0 F_o. The covariance is that of the regression about its own misfit and knows nothing of that.
    """

    def coefficients(self, balance: Balance, gain_sd: float = 0.0) -> tuple[Array, Array]:
        """(2 m,) F_o and F_o b (N) of each muscle, which may be negative, and their covariance."""
        weighted = balance.whitened(balance.noise)
        columns = np.stack(
            [weighted.sum_lines(weighted.pull), weighted.sum_lines(weighted.pull * weighted.strain[:, :, None])],
            axis=2,
        )
        jacobian = columns.reshape(len(columns), -1, columns.shape[-1]).transpose(0, 2, 1)
        matrix, right = jacobian.reshape(-1, jacobian.shape[2]), weighted.needed.ravel()
        solution = np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0], dtype=np.float64)
        residual = (right - matrix @ solution).reshape(weighted.needed.shape)
        return solution, regression_covariance(jacobian, residual, weighted.by_gain, gain_sd)


@dataclass(frozen=True)
class NonlinearLeastSquares:
    """Least squares on the muscle law as it is: Young (2016), eqs. 5.11-5.15, over the logs of F_o and b.

    The minimum of the sum of squares is sought by a trust-region method (Branch et al. 1999) with the exact Jacobian,
    within ``REACH`` prior sds, from several starts. A first search weighs the rows by the noise that the unknown
    wrench makes; a second by the residuals' own covariance (Zellner 1962), as errors of the condyle's place weigh too.

    Lengths come from measured places, and the unmodelled force that is the noise has moved the jaw: the regressors are
    noisy, and correlated with the noise. Where a maneuver excites all muscles apart this hardly matters. Where nearly
    parallel ones hardly move apart, as in a slow opening, the estimate of their difference is biased by many of the
    claimed sds; a filter, for which both are part of the model, is not.
    """

    rows: Rows = "all"  # of the balance: the three moments (Young) or all five
    starts: int = 4  # how many starts; the first is the prior's mean, the others are drawn from the prior
    use_prior: bool = False  # whether the prior belongs to the sum of squares; Young (2016) has none
    seed: int = 0  # of the starts
    smoothing_s: float = SMOOTHING_S  # window of the balance's smoothing (s)
    name: str = "nonlinear least squares"

    def __post_init__(self) -> None:
        """Check the number of starts."""
        if self.starts < 1:
            raise InputError(f"starts is {self.starts}; allowed: 1 or more")

    def estimate(self, record: Record) -> Estimate:
        """The best of the minima found; a parameter at the search's bound was not determined, whatever its sd."""
        plain = balance_of(record, rows=self.rows, smoothing_s=self.smoothing_s)
        mean, sd = np.asarray(record.prior.mean), np.asarray(record.prior.sd)
        bounds = mean - REACH * sd, mean + REACH * sd
        rng = np.random.default_rng(self.seed)
        drawn = mean + sd * rng.uniform(-2.0, 2.0, (self.starts - 1, len(mean)))
        first = plain.whitened(plain.noise)
        minima = [self._search(first, start, bounds, mean, sd) for start in (mean, *drawn)]
        parameters = min(minima, key=lambda pair: pair[1])[0]
        residual = plain.needed - exerted(plain, parameters)
        balance = plain.whitened(residual.T @ residual / len(residual))
        parameters, _ = self._search(balance, parameters, bounds, mean, sd)
        covariance = regression_covariance(
            exerted_jacobian(balance, parameters),
            balance.needed - exerted(balance, parameters),
            balance.by_gain,
            record.gain_sd,
            np.diag(sd**-2.0) if self.use_prior else None,
        )
        return Estimate(self.name, record.time[-1:], parameters[None], covariance[None])

    def _search(
        self, balance: Balance, start: Array, bounds: tuple[Array, Array], mean: Array, sd: Array
    ) -> tuple[Array, float]:
        """The minimum that a search from ``start`` ends at, and half its sum of squares."""

        def residual(parameters: Array) -> Array:
            data = (exerted(balance, parameters) - balance.needed).ravel()
            return np.concatenate([data, (parameters - mean) / sd]) if self.use_prior else data

        def jacobian(parameters: Array) -> Array:
            data = exerted_jacobian(balance, parameters).reshape(-1, len(mean))
            return np.vstack([data, np.diag(1.0 / sd)]) if self.use_prior else data

        result = least_squares(residual, np.clip(start, *bounds), jacobian, bounds, x_scale=sd, xtol=1e-10, ftol=1e-12)
        return result.x, float(result.cost)


def tensions(balance: Balance, parameters: Array) -> Array:
    """(N, lines) F_o exp(b e) in N, Young (2016), eq. 2.2; ``parameters`` (2 m,) logs."""
    log_F_o, log_b = parameters[0::2][balance.muscle], parameters[1::2][balance.muscle]
    pulls: Array = np.exp(log_F_o + np.exp(log_b) * balance.strain)
    return pulls


def exerted(balance: Balance, parameters: Array) -> Array:
    """(N, r) what muscles with these log-parameters (2 m,) exert: g(p) of Young (2016), eq. 5.5."""
    result: Array = np.einsum("nl,nlr->nr", tensions(balance, parameters), balance.pull)
    return result


def exerted_jacobian(balance: Balance, parameters: Array) -> Array:
    """(N, r, 2 m) its derivative by the log-parameters."""
    per_line = tensions(balance, parameters)[:, :, None] * balance.pull
    exponent = np.exp(parameters[1::2])[balance.muscle] * balance.strain
    columns = np.stack([balance.sum_lines(per_line), balance.sum_lines(per_line * exponent[:, :, None])], axis=2)
    return columns.reshape(len(columns), -1, columns.shape[-1]).transpose(0, 2, 1)
