"""Batch estimates from the balance of moments: linearised (Young 2016, section 5.2) and as it is (section 5.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from eval.thesis.methods.moment_balance import Balance, balance_of
from jawenv.anatomy import Prior
from jawenv.recordings.record import Record

Array = NDArray[np.float64]
REACH = 5.0  # prior sds to either side of the prior's mean: the bounds of the search, and the filter's


def linear(balance: Balance) -> Array:
    """(2 m,) F_o and F_o b (N) of each muscle, which may be negative, from the law expanded at strain 0.

    F = F_o (1 + b e), Young (2016), eqs. 5.6-5.10, is linear in F_o and F_o b, so a pseudo-inverse solves it; and
    wrong, for at b = 8 a strain of 0.3 gives 3.4 F_o where the law gives 11.0 F_o.
    """
    weighted = balance.whitened(balance.noise)
    columns = np.stack(
        [weighted.sum_lines(weighted.pull), weighted.sum_lines(weighted.pull * weighted.strain[:, :, None])], axis=2
    )
    matrix = columns.reshape(len(columns), -1, columns.shape[-1]).transpose(0, 2, 1).reshape(-1, 2 * balance.muscles)
    return np.asarray(np.linalg.lstsq(matrix, weighted.needed.ravel(), rcond=None)[0], dtype=np.float64)


def nonlinear(record: Record, starts: int = 4, *, use_prior: bool = False) -> Array:
    """(2 m,) natural logs of F_o and b by least squares on the law as it is: Young (2016), eqs. 5.11-5.15.

    The minimum of the sum of squares is sought by a trust-region method (Branch et al. 1999) with the exact Jacobian,
    within ``REACH`` prior sds, from several starts. A first search weighs the rows by the noise that the unknown
    wrench makes; a second by the residuals' own covariance (Zellner 1962), as errors of the condyle's place weigh too.

    Lengths come from measured places, and the unmodelled force that is the noise has moved the jaw: the regressors are
    noisy, and correlated with the noise. Where a maneuver excites all muscles apart this hardly matters. Where nearly
    parallel ones hardly move apart, as in a slow opening, the estimate of their difference is biased; a filter, for
    which both are part of the model, is not.

    Args:
        record: of the midline model.
        starts: 1 or more; the first is the prior's mean, the others are drawn from the prior.
        use_prior: whether the prior belongs to the sum of squares; Young (2016) has none.
    """
    plain = balance_of(record)
    mean, sd = np.asarray(record.prior.mean), np.asarray(record.prior.sd)
    drawn = mean + sd * np.random.default_rng(0).uniform(-2.0, 2.0, (starts - 1, len(mean)))
    first = plain.whitened(plain.noise)
    minima = [_search(first, start, record.prior, use_prior) for start in (mean, *drawn)]
    best = min(minima, key=lambda pair: pair[1])[0]
    residual = plain.needed - exerted(plain, best)
    return _search(plain.whitened(residual.T @ residual / len(residual)), best, record.prior, use_prior)[0]


def _search(balance: Balance, start: Array, prior: Prior, use_prior: bool) -> tuple[Array, float]:
    """The minimum that a search from ``start`` ends at, and half its sum of squares."""
    mean, sd = np.asarray(prior.mean), np.asarray(prior.sd)
    bounds = mean - REACH * sd, mean + REACH * sd

    def residual(parameters: Array) -> Array:
        data = (exerted(balance, parameters) - balance.needed).ravel()
        return np.concatenate([data, (parameters - mean) / sd]) if use_prior else data

    def jacobian(parameters: Array) -> Array:
        data = exerted_jacobian(balance, parameters).reshape(-1, len(mean))
        return np.vstack([data, np.diag(1.0 / sd)]) if use_prior else data

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
