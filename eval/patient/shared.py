"""Treatments whose patient has the same anatomy in all, which is known only within sds.

What is known after each is a normal belief about x = (muscles, the patient's own anatomy). With beliefs about the
muscles alone, the errors that come of the anatomy would count as if they were independent from one treatment to the
next. The session's part (load cell, mouthpiece, tilt) is drawn anew for each treatment and integrated out in each.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from eval.entries import Entry
from jawenv.anatomy import Prior
from jawenv.anatomy.knowledge import knowledge
from jawenv.laboratory.analysis.joint_likelihood import JointLikelihood

Array = NDArray[np.float64]


def is_shared(entry: Entry) -> bool:
    """Whether an entry's patients have an anatomy that is known only within sds."""
    return not knowledge(entry.env_kwargs.get("knowledge")).exact


def at_start(prior: Prior, size: int) -> tuple[Array, Array]:
    """Mean and covariance of x (size) before anything is measured."""
    sds = np.ones(size)
    sds[: len(prior.sd)] = prior.sd
    mean = np.zeros(size)
    mean[: len(prior.mean)] = prior.mean
    return mean, np.diag(np.square(sds))


def change(first: JointLikelihood, later: JointLikelihood, prior: Prior) -> tuple[Array, Array]:
    """How much the muscles have changed between two treatments of a patient.

    The muscles of both have the cohort's prior, independently: what is said of a change is what was measured. The
    anatomy is one and has one prior, so that errors which come of it and are alike in both treatments cancel.

    Args:
        first: what one treatment has told.
        later: what another one has told.
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
    for places, each in ((then, first), (now, later)):
        information[np.ix_(places, places)] += each.information
        vector[places] += each.vector
    mean, cov = JointLikelihood(information, vector).posterior(mean, cov)
    difference = np.hstack([-np.eye(parameters), np.eye(parameters), np.zeros((parameters, size - parameters))])
    changed: Array = difference @ cov @ difference.T
    return difference @ mean, changed
