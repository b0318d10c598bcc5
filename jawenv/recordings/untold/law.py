"""Tensions by the natural-log parameters, for many beliefs at once, and what of a muscle's law these cannot bend."""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.recordings.estimate import Array
from jawenv.recordings.untold.blocks import Blocks

STRAINS = np.linspace(-0.02, 0.22, 15)
"""Strains of muscles between closed and wide open."""
_BENDS = 2
"""Curvatures of each muscle's law."""


def tensions(basis: Any, theta: Array) -> tuple[Array, Array]:
    """Coefficients (N, c) of N natural-log parameters (N, p), and their derivatives (N, c, p)."""
    log_pull, b = theta[:, 0::2], np.exp(theta[:, 1::2])
    centre, polynomials = basis["centre"], basis["polynomials"]  # lowest power first
    size = polynomials.shape[-1]
    powers = b[..., None] ** np.arange(size)
    slopes = np.arange(size) * b[..., None] ** np.maximum(np.arange(size) - 1, 0)
    value, slope = np.einsum("mkp,nmp->nmk", polynomials, powers), np.einsum("mkp,nmp->nmk", polynomials, slopes)
    factor = np.exp(log_pull + b * centre)[..., None]
    coefficients = factor * value
    by_b = factor * b[..., None] * (centre[:, None] * value + slope)
    number, muscles = b.shape
    derivative = np.zeros((number, muscles, size, muscles, 2))
    every = np.arange(muscles)
    derivative[:, every, :, every, 0] = np.swapaxes(coefficients, 0, 1)
    derivative[:, every, :, every, 1] = np.swapaxes(by_b, 0, 1)
    return coefficients.reshape(number, -1), derivative.reshape(number, muscles * size, 2 * muscles)


def bends(blocks: Blocks) -> Array:
    """(c, 2 per muscle) coefficients that bend each law by a quadratic and a cubic of the strain, 1 of it rms.

    They are orthogonal to what F_o and b do to it.
    """
    muscles, nodes = blocks.nominal.shape
    away = STRAINS - STRAINS.mean()
    away = away / np.abs(away).max()
    axes, _ = np.linalg.qr(np.stack([away**power for power in range(2 + _BENDS)], axis=1))
    shapes = axes[:, 2:] * np.sqrt(len(STRAINS))
    found = np.zeros((muscles, nodes, muscles, _BENDS))
    for m in range(muscles):
        exponentials = np.exp(blocks.basis["nodes"][m] * (STRAINS - blocks.basis["centre"][m])[:, None])
        tension = exponentials @ blocks.nominal[m]
        relative = exponentials / tension[:, None]
        small = 1e-4 * np.eye(nodes) / np.abs(blocks.nominal[m]).max()
        target = np.vstack([shapes * np.sign(tension)[:, None], np.zeros((nodes, _BENDS))])
        found[m, :, m] = np.linalg.lstsq(np.vstack([relative, small]), target, rcond=None)[0]
    return found.reshape(muscles * nodes, muscles * _BENDS)
