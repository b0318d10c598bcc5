"""Calibration of the filter: whether the truth lies where the posterior predicts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from jawenv.base.errors import InputError

Array = npt.NDArray[np.float64]


def _cholesky(covariance: Array) -> Array:
    """Lower Cholesky factor, or an InputError that says what is wrong."""
    try:
        factor: Array = np.linalg.cholesky(covariance).astype(np.float64, copy=False)
    except np.linalg.LinAlgError:
        raise InputError("covariance is not positive definite; allowed: a symmetric positive definite matrix") from None
    return factor


def nees(error: Array, covariance: Array) -> Array:
    """Normalised estimation error squared, e^T P^-1 e (Bar-Shalom, Li & Kirubarajan 2001, section 5.4).

    An honest Gaussian posterior over P parameters has a NEES that is chi-squared with P degrees of freedom: P
    on average. Larger means overconfident, smaller means too cautious.

    Args:
        error: (..., P) estimate minus truth.
        covariance: (..., P, P).

    Returns:
        (...).
    """
    factor = _cholesky(covariance)
    white = np.linalg.solve(factor, error[..., None])[..., 0]
    squared: Array = np.sum(np.square(white), axis=-1)
    return squared


def alarm_rings(misfit: Array) -> npt.NDArray[np.bool_]:
    """Whether the filter's alarm rings: the readings do not fit the model, and the belief is not to be trusted.

    Args:
        misfit: (...) largest of an episode, `info["misfit"]`; one that is not a number rings.

    Returns:
        (...) bool.
    """
    rings: npt.NDArray[np.bool_] = ~(np.asarray(misfit) <= 1.0)
    return rings


YELLOW = 0.75
"""Misfit from which an episode is looked at twice: few honest ones are above, many that a small error spoils."""


def alarm_word(misfit: float) -> str:
    """The alarm of one episode in a word: ``silent``, ``yellow`` or ``rings``."""
    if alarm_rings(np.array(misfit)):
        return "rings"
    return "yellow" if misfit > YELLOW else "silent"


def nees_band(patients: int, parameters: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval in which the mean NEES over patients of an honest filter lies.

    Args:
        patients: over how many the mean is taken, >= 1.
        parameters: degrees of freedom of one patient's NEES.
        confidence: probability of the interval, in (0, 1).

    Returns:
        Low and high end: quantiles of chi-squared with `patients * parameters` degrees of freedom, over
        `patients`.
    """
    from scipy.stats import chi2

    tails = [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0]
    low, high = chi2.ppf(tails, patients * parameters) / patients
    return float(low), float(high)


def covered(error: Array, sd: Array, sigmas: float) -> npt.NDArray[np.bool_]:
    """Whether the truth lies within a number of standard deviations of the mean.

    Args:
        error: (..., P) estimate minus truth.
        sd: (..., P).
        sigmas: half-width of the interval; honest shares are 68.3, 95.4 and 99.7 % for 1, 2 and 3.

    Returns:
        (..., P) bool.
    """
    inside: npt.NDArray[np.bool_] = np.abs(error) <= sigmas * sd
    return inside


def log_density(truth: Array, mean: Array, covariance: Array) -> Array:
    """Log of a Gaussian's density at the truth: the log score of that belief.

    Args:
        truth: (..., P).
        mean: (..., P).
        covariance: (..., P, P).

    Returns:
        (...) in nats.
    """
    log_det = 2.0 * np.sum(np.log(np.diagonal(_cholesky(covariance), axis1=-2, axis2=-1)), axis=-1)
    size = truth.shape[-1]
    density: Array = -0.5 * (nees(mean - truth, covariance) + log_det + size * np.log(2.0 * np.pi))
    return density


def claimed_information(covariance: Array, prior_sd: Array) -> Array:
    """Half the log of prior over posterior volume: what the filter says it has learned.

    Args:
        covariance: (..., P, P) of the posterior.
        prior_sd: (P,) of an independent Gaussian prior.

    Returns:
        (...) in nats; 1 nat shrinks each of P standard deviations by the factor exp(-1/P): for 12 by 8 %.
    """
    log_sd = np.log(np.diagonal(_cholesky(covariance), axis1=-2, axis2=-1))
    gained: Array = np.sum(np.log(prior_sd) - log_sd, axis=-1)
    return gained


def true_information(truth: Array, mean: Array, covariance: Array, prior_mean: Array, prior_sd: Array) -> Array:
    """Log posterior minus log prior density at the truth: a proper score, which overconfidence cannot raise.

    Claimed minus true information is the honesty gap, exactly (NEES of the posterior - NEES of the prior) /
    2.

    Args:
        truth: (..., P).
        mean: (..., P) of the posterior.
        covariance: (..., P, P) of the posterior.
        prior_mean: (P,).
        prior_sd: (P,).

    Returns:
        (...) in nats.
    """
    prior = log_density(truth, prior_mean, np.diag(np.square(prior_sd)))
    gained: Array = log_density(truth, mean, covariance) - prior
    return gained
