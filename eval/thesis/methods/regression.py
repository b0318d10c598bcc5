"""Covariance of a least-squares estimate whose noise is correlated in time, and which shares one gain error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Windows of the smoothing overlap with the next two. What is wrong for longer, a smoothed error of the condyle's place
# say, is given as much time again.
LAGS = 4


def regression_covariance(
    jacobian: Array, residual: Array, by_gain: Array, gain_sd: float, prior_information: Array | None = None
) -> Array:
    """Covariance I^-1 S I^-1 with S by Newey & West (1987), and what an unknown gain adds.

    The noise need be neither white nor of the size that the weights suppose. A gain error is the same in all
    equations, so no residual shows it: its uncertainty is carried over, as considered and not estimated.

    Args:
        jacobian: (N, r, p) of the r rows of N times in order, weighted.
        residual: (N, r) weighted.
        by_gain: (N, r) derivative of the weighted residual by the relative gain error.
        gain_sd: its sd.
        prior_information: (p, p) of a prior that the estimate was drawn to.

    Returns:
        (p, p); by pseudo-inverse where the equations do not determine all.
    """
    times, _, parameters = jacobian.shape
    scores = np.einsum("nrp,nr->np", jacobian, residual)
    spread = scores.T @ scores
    for lag in range(1, min(LAGS, times - 1) + 1):
        product = scores[lag:].T @ scores[:-lag]
        spread += (1.0 - lag / (LAGS + 1.0)) * (product + product.T)
    # The residuals are as much smaller than the noise as parameters have been fitted to them.
    spread *= residual.size / max(residual.size - parameters, 1)
    information = np.einsum("nrp,nrq->pq", jacobian, jacobian)
    if prior_information is not None:
        spread, information = spread + prior_information, information + prior_information
    inverse = scaled_inverse(information)
    by_gain_error = inverse @ np.einsum("nrp,nr->p", jacobian, by_gain)
    covariance: Array = inverse @ spread @ inverse + gain_sd**2 * np.outer(by_gain_error, by_gain_error)
    return 0.5 * (covariance + covariance.T)


def scaled_inverse(matrix: Array) -> Array:
    """Pseudo-inverse of a symmetric matrix whose rows may differ in scale by orders of magnitude."""
    diagonal = np.diag(matrix)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    inverse: Array = np.linalg.pinv(matrix / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)
    return inverse
