"""The belief where readings leave more than one motion possible: a sum of normals.

Where readings leave the pose open, as those of one point do, the posterior has several modes. The densest is what the
filter goes on with (``mode_mean``, ``mode_cov``). The *others*, one normal for all of them together, are what was found
beside it when readings were last filtered again (``replay``), and stay as they were until the next time. The
belief that everybody else sees is the normal with the mean and covariance of the sum (Alspach & Sorenson 1972, IEEE
Trans. Autom. Control 17:439). Without others it is the mode, to the bit.

A mode's weight would be its share of the posterior, Laplace's approximation: the density at the mode times the
normal's volume. But the density integrates the motion out along straight lines, and is off by some nats. Of two modes
one of which is near the truth, the denser one is it less often than that: the log of the odds is ``TRUST`` times the
difference of the log-densities (logistic regression; ``docs/architecture.md`` has the table).
"""

from __future__ import annotations

from math import exp, sqrt
from typing import Any

import numpy as np

from jawenv.compiled import njit

MOST_MODES = 8  # from as many starts
SAME = 0.5  # sds, in every parameter, within which two modes are one
TRUST = 0.4
NEGLIGIBLE = 1e-9  # weight of others that are none


def mixture_fields(parameters: int) -> list[Any]:
    """What a belief carries of the sum, as fields of a dtype; ``modes_about`` is what each was filtered at."""
    square = (parameters, parameters)
    return [
        ("mode_mean", "f8", (parameters,)),
        ("mode_cov", "f8", square),
        ("n_modes", "i8"),
        ("modes_density", "f8", (MOST_MODES,)),
        ("modes_about", "f8", (MOST_MODES, parameters)),
        ("modes_mean", "f8", (MOST_MODES, parameters)),
        ("modes_cov", "f8", (MOST_MODES, *square)),
        ("others_weight", "f8"),
        ("others_mean", "f8", (parameters,)),
        ("others_cov", "f8", square),
        ("mean", "f8", (parameters,)),
        ("cov", "f8", square),
    ]


@njit
def forget_modes(belief):
    """No others."""
    belief.n_modes, belief.others_weight = 0, 0.0


@njit
def distance(belief, parameters):
    """The largest distance of a parameter from the mode's mean, in its sds."""
    furthest = 0.0
    for i in range(parameters.shape[0]):
        furthest = max(furthest, abs(belief.mode_mean[i] - parameters[i]) / sqrt(belief.mode_cov[i, i]))
    return furthest


@njit
def nearest_mode(belief):
    """The mode kept that the belief is nearest to, and its ``distance``; -1 if there is none."""
    nearest, least = -1, np.inf
    for k in range(belief.n_modes):
        apart = distance(belief, belief.modes_mean[k])
        if apart < least:
            nearest, least = k, apart
    return nearest, least


@njit
def keep_mode(belief, density, about):
    """Keep the belief, filtered at ``about``, as a mode of this log-density: a new one, or in place of a thinner.

    Returns its number; -1 where it is not kept.
    """
    k, apart = nearest_mode(belief)
    if not apart < SAME:
        k = belief.n_modes
        belief.n_modes += 1
    elif not density > belief.modes_density[k]:
        return -1
    belief.modes_density[k] = density
    belief.modes_about[k] = about
    belief.modes_mean[k] = belief.mode_mean
    belief.modes_cov[k] = belief.mode_cov
    return k


@njit
def densest_mode(belief):
    """The mode of the largest density; -1 if there is none."""
    best = -1
    for k in range(belief.n_modes):
        if best < 0 or belief.modes_density[k] > belief.modes_density[best]:
            best = k
    return best


@njit
def add_normal(weight, mean, cov, total, new_mean, new_cov):
    """Moments of a sum of normals that weigh ``total`` so far and ``weight`` more, in place."""
    share = weight / (total + weight)
    size = mean.shape[0]
    for i in range(size):
        for j in range(size):
            apart = (mean[i] - new_mean[i]) * (mean[j] - new_mean[j])
            new_cov[i, j] = (1.0 - share) * new_cov[i, j] + share * cov[i, j] + share * (1.0 - share) * apart
    for i in range(size):
        new_mean[i] += share * (mean[i] - new_mean[i])


@njit
def set_others(belief):
    """All modes kept but the densest become the belief's others."""
    best = densest_mode(belief)
    mean, cov, total = belief.others_mean, belief.others_cov, 0.0
    mean[:] = 0.0
    cov[:, :] = 0.0
    for k in range(belief.n_modes):
        weight = exp(TRUST * (belief.modes_density[k] - belief.modes_density[best]))
        if k != best and weight > NEGLIGIBLE:
            add_normal(weight, belief.modes_mean[k], belief.modes_cov[k], total, mean, cov)
            total += weight
    belief.others_weight = total / (1.0 + total)


@njit
def sum_up(belief):
    """``mean`` and ``cov`` of the mode and the others together."""
    belief.mean[:] = belief.mode_mean
    belief.cov[:, :] = belief.mode_cov
    others = belief.others_weight
    if others > 0.0:
        add_normal(others, belief.others_mean, belief.others_cov, 1.0 - others, belief.mean, belief.cov)
