"""Cholesky factors of matrices that rounding may have left without an inverse."""

from __future__ import annotations

import numpy as np

from jawenv.recordings.estimate import Array

_RIDGES = (0.0, 1e-14, 1e-12, 1e-10, 1e-8)
"""Shares of the diagonal that are added to it, the first that helps."""


def factor(matrix: Array) -> Array:
    """Lower Cholesky factors (..., n, n).

    Raises:
        numpy.linalg.LinAlgError: a matrix is not finite, or far from definite.
    """
    for ridge in _RIDGES if np.isfinite(matrix).all() else ():
        try:
            return np.asarray(np.linalg.cholesky(matrix * (1.0 + ridge * np.eye(matrix.shape[-1]))))
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError
