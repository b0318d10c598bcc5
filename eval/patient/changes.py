"""Changes of the muscles since the first treatment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eval.figures import words
from eval.patient.belief import at_start
from eval.patient.charts import SD_95
from eval.patient.treatments import Treatment
from jawenv.analysis.joint_likelihood import JointLikelihood
from jawenv.anatomy import Prior

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Change:
    """The change of each parameter since the first treatment, as natural logs."""

    mean: Array  # (P,)
    sd: Array  # (P,)

    def of(self, parameter: int) -> tuple[float, float, float]:
        """The factor by which a parameter has changed, and the ends of its 95 % interval."""
        value, reach = self.mean[parameter], SD_95 * self.sd[parameter]
        return math.exp(value), math.exp(value - reach), math.exp(value + reach)


def change(first: JointLikelihood, later: JointLikelihood, prior: Prior) -> tuple[Array, Array]:
    """The change of the muscles between two treatments of a patient.

    The muscles of both have the cohort's prior, independently: only measurements tell of a change. The
    anatomy is one and has one prior, so that errors which come of it and are alike in both treatments cancel.

    Args:
        first: likelihood of one treatment.
        later: likelihood of another one.
        prior: of the muscles.

    Returns:
        Mean (P,) of the later log parameters minus the first, and covariance (P, P).
    """
    parameters, size = len(prior.mean), len(first.vector)
    # (muscles then, muscles now, anatomy)
    then = np.r_[0:parameters, 2 * parameters : size + parameters]
    now = np.r_[parameters : size + parameters]
    mean, cov = at_start(Prior(np.tile(prior.mean, 2), np.tile(prior.sd, 2)), size + parameters)
    information, vector = np.zeros_like(cov), np.zeros_like(mean)
    for places, likelihood in ((then, first), (now, later)):
        information[np.ix_(places, places)] += likelihood.information
        vector[places] += likelihood.vector
    mean, cov = JointLikelihood(information, vector).posterior(mean, cov)
    difference = np.hstack([-np.eye(parameters), np.eye(parameters), np.zeros((parameters, size - parameters))])
    changed: Array = difference @ cov @ difference.T
    return difference @ mean, changed


def change_of(course: Sequence[Treatment], prior: Prior) -> Change | None:
    """The change from the first treatment to the last; None of one, or where the anatomy is known exactly.

    Args:
        course: treatments of a patient.
        prior: of the muscles.
    """
    first, last = course[0].likelihood, course[-1].likelihood
    if len(course) == 1 or first is None or last is None:
        return None
    mean, cov = change(first, last, prior)
    return Change(mean, np.sqrt(np.diagonal(cov)))


def change_in_words(factor: float, low: float, high: float) -> str:
    """A factor with the ends of its interval, such as `softer by 20 % (12 … 27)`."""
    word, sign = ("softer", -1.0) if factor < 1.0 else ("stiffer", 1.0)
    value, *ends = (100.0 * sign * (ratio - 1.0) for ratio in (factor, low, high))
    low, high = sorted(ends)
    return f"{word} by {words.number(value, 0)} % ({words.number(low, 0)} … {words.number(high, 0)})"
