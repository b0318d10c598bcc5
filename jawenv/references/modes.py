"""The posterior where readings leave more than one motion possible: a sum of normals, one for each mode.

The moments of the sum are the belief (Alspach & Sorenson 1972, IEEE Trans. Autom. Control 17:439). A mode's weight
would be its share of the posterior, Laplace's approximation: the density at the mode times the normal's volume. But the
density integrates the motion out along straight lines, and is off by some nats. Of two modes one of which is near the
truth, the denser one is it less often than that: the log of the odds is ``TRUST`` times the difference of the
log-densities (a logistic regression over pairs of modes).
"""

from __future__ import annotations

from functools import cache
from math import exp, sqrt
from typing import Annotated, Any

import numpy as np

from jawenv.filter.belief.state import Belief
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype

MAX_MODES = 9  # from as many starts
SAME = 0.5  # sds, in every parameter, within which two modes are one
TRUST = 0.4


class Modes:
    """The modes found: log-density, mean and covariance of each."""

    number: int
    density: Annotated[Array, MAX_MODES]
    mean: Annotated[Array, MAX_MODES, "parameters"]
    cov: Annotated[Array, MAX_MODES, "parameters", "parameters"]


@cache
def modes_dtype(parameters: int) -> np.dtype[np.void]:
    """Dtype of ``Modes``."""
    return record_dtype(Modes, parameters=parameters)


@njit
def distance(belief: Belief, parameters):
    """The largest distance of a parameter from the belief's mean, in its sds."""
    furthest = 0.0
    for i in range(parameters.shape[0]):
        furthest = max(furthest, abs(belief.mean[i] - parameters[i]) / sqrt(belief.cov[i, i]))
    return furthest


@njit
def nearest_mode(modes: Modes, belief: Belief):
    """The mode that the belief is nearest to, and its ``distance``; -1 if there is none."""
    nearest, smallest = -1, np.inf
    for k in range(modes.number):
        separation = distance(belief, modes.mean[k])
        if separation < smallest:
            nearest, smallest = k, separation
    return nearest, smallest


@njit
def keep_mode(modes: Modes, belief: Belief, density):
    """Store the belief as a mode of this log-density: a new one, or in place of a close one of lower density."""
    k, separation = nearest_mode(modes, belief)
    if not separation < SAME:
        k = modes.number
        modes.number += 1
    elif not density > modes.density[k]:
        return
    modes.density[k] = density
    modes.mean[k] = belief.mean
    modes.cov[k] = belief.cov


def mixture_moments(modes: Any) -> tuple[Any, Any]:
    """Mean (p,) and covariance (p, p) of the sum of at least one mode."""
    number = int(modes["number"])
    density = modes["density"][:number]
    weight = np.array([exp(TRUST * (value - density.max())) for value in density])
    weight /= weight.sum()
    means, covs = modes["mean"][:number], modes["cov"][:number]
    mean = weight @ means
    deviations = means - mean
    return mean, np.einsum("k,kij->ij", weight, covs) + np.einsum("k,ki,kj->ij", weight, deviations, deviations)
