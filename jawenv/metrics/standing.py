"""Muscles on which the data have a verdict, of many beliefs at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, owens_t

from jawenv.metrics.diagnosis import BLOCKED_B, CONFIDENCE, MEASURED, STIFF_F_O_N

Array = NDArray[np.float64]
_SMALL = 1e-9


def standing(mean: Array, cov: Array, prior_sd: Array) -> NDArray[np.bool_]:
    """Mask (..., M) of the muscles on which the data have a verdict: as of ``jawenv.metrics.verdicts.verdict``.

    Args:
        mean: (..., 2 M) log F_o and log b of each.
        cov: (..., 2 M, 2 M).
        prior_sd: (2 M,).
    """
    sd = np.sqrt(np.diagonal(cov, axis1=-2, axis2=-1))
    above = (mean - np.tile(np.log([STIFF_F_O_N, BLOCKED_B]), sd.shape[-1] // 2)) / sd
    measured = sd <= MEASURED * prior_sd
    raised = (ndtr(above) >= CONFIDENCE) & measured
    correlation = np.diagonal(cov, offset=1, axis1=-2, axis2=-1)[..., ::2] / (sd[..., ::2] * sd[..., 1::2])
    neither = _both_below(-above[..., ::2], -above[..., 1::2], correlation)
    normal = (neither >= CONFIDENCE) & measured[..., ::2] & measured[..., 1::2]
    stands: NDArray[np.bool_] = raised[..., ::2] | raised[..., 1::2] | normal
    return stands


def _both_below(h: Array, k: Array, correlation: Array) -> Array:
    """P(x < h, y < k) of standard normals with a correlation, by Owen's T (Owen 1956, Ann. Math. Stat. 27:1075)."""
    h, k = (np.where(np.abs(value) < _SMALL, _SMALL, value) for value in (h, k))
    root = np.sqrt(np.maximum(1.0 - correlation**2, _SMALL**2))
    parts = owens_t(h, (k / h - correlation) / root) + owens_t(k, (h / k - correlation) / root)
    shares: Array = 0.5 * (ndtr(h) + ndtr(k)) - parts - 0.5 * (h * k < 0.0)
    return shares
