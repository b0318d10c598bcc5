"""Expected information gain in the units of Bayesian experimental design: bounds that any design can be given."""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, multivariate_t

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import whole_number
from jawenv.inference.likelihood import log_likelihood
from jawenv.inference.patient_law import PatientLaw
from jawenv.inference.settings import Array
from jawenv.recordings.record import Record

CONTRASTS = 64
DEGREES_OF_FREEDOM = 10
"""Of Student's t about the belief, from which contrasts are drawn: its tails are heavier than a posterior's."""


@dataclass(frozen=True)
class InformationGain:
    """The information of one record about its patient, nats; means over patients of the law bound the expected gain."""

    lower: float
    """Contrastive lower bound; NaN without contrasts."""
    upper: float
    """Contrastive upper bound; likewise."""
    posterior: float
    """Barber and Agakov's lower bound, with the belief as the posterior."""
    effective: float
    """Effective number of contrasts: near 1 the contrastive bounds are far apart."""


def contrastive_bounds(log_likelihoods: ArrayLike, log_weights: ArrayLike | None = None) -> tuple[Array, Array]:
    """Contrastive bounds on the expected information gain of a design or a policy, a pair of values per experiment.

    With contrasts from the prior these are the sequential prior-contrastive lower bound, never above log(L + 1), and
    the nested upper bound (sPCE and sNMC; Foster, Ivanova, Malik & Rainforth 2021, ICML, Proc. Mach. Learn. Res.
    139:3384). With contrasts from a proposal that knows the readings they are the adaptive lower bound (ACE; Foster,
    Jankowiak, O'Meara, Teh & Rainforth 2020, AISTATS, Proc. Mach. Learn. Res. 108:2959) and the variational nested
    upper one (VNMC; Foster et al. 2019, NeurIPS 32), tight with few contrasts where the proposal is near the posterior.

    The mean of the lower values is below the gain for every proposal, and for every function of readings and
    parameters in the likelihood's place; that of the upper ones is above it only for the true likelihood.

    Args:
        log_likelihoods: (n, L + 1) of n experiments' readings, nats: at the true parameters, then at L contrasts.
        log_weights: (n, L + 1) log-density of the prior less that of the proposal, at the same parameters; -inf where
            the prior has nobody. None for contrasts that are drawn from the prior.

    Returns:
        lower: (n,) nats, of which the mean is taken.
        upper: (n,) likewise.

    Raises:
        InputError: another shape, fewer than one contrast, or a value that is NaN.
    """
    values = np.asarray(log_likelihoods, dtype=np.float64)
    weights = np.zeros_like(values) if log_weights is None else np.asarray(log_weights, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] < 2 or values.shape != weights.shape:
        raise InputError(f"log_likelihoods has shape {values.shape}; allowed: (n, L + 1), as log_weights, L 1 or more")
    evidence = np.where(weights == -np.inf, -np.inf, values + weights)
    if np.isnan(values).any() or np.isnan(evidence).any():
        raise InputError("log_likelihoods or log_weights is NaN; allowed: numbers, and -inf")
    contrasts = values.shape[1] - 1
    lower = values[:, 0] - (logsumexp(evidence, axis=1) - log(contrasts + 1))
    upper = values[:, 0] - (logsumexp(evidence[:, 1:], axis=1) - log(contrasts))
    return lower, upper


def information_gain(
    record: Record, law: PatientLaw, mean: ArrayLike, cov: ArrayLike, *, contrasts: int = CONTRASTS, seed: int = 0
) -> InformationGain:
    """Bounds on what one record tells of its patient, by ``log_likelihood`` and a normal belief.

    The contrasts come from Student's t about the belief. Barber and Agakov's bound is log q(theta | record) plus the
    entropy of the law (Barber & Agakov 2003, NeurIPS 16): below the contrastive one by how far the belief is from the
    posterior, Kullback and Leibler's divergence.

    Args:
        record: with its truth, of a patient of the law, p parameters.
        law: of the patients: the prior.
        mean: (p,) belief after the record, as of the environment's filter; any other normal posterior will do.
        cov: (p, p) its covariance.
        contrasts: 0 or more, each a likelihood of the record. None are needed for ``posterior``.
        seed: of the contrasts.

    Raises:
        InputError: no truth, one that is not of the law, a covariance that is not positive definite, or a number out
            of range.
    """
    number = whole_number(contrasts)
    if number is None or number < 0:
        raise InputError(f"contrasts is {shown(contrasts)}; allowed: a whole number, 0 or more")
    if record.truth is None:
        raise InputError("record: truth is None; allowed: the parameters of the patient, as of a simulated record")
    if law.log_density(record.truth[None])[0] == -np.inf:
        raise InputError("record: truth is not of the law; allowed: the law from which its patient was drawn")
    try:
        posterior = float(multivariate_normal(mean, cov).logpdf(record.truth)) + law.entropy
        proposal = multivariate_t(mean, cov, df=DEGREES_OF_FREEDOM, seed=np.random.default_rng(seed))
    except (ValueError, np.linalg.LinAlgError):
        raise InputError("cov is no covariance; allowed: a finite, symmetric, positive definite matrix") from None
    if number == 0:
        return InformationGain(float("nan"), float("nan"), posterior, 0.0)
    theta = np.vstack([record.truth, proposal.rvs(number).reshape(number, -1)])
    weights = law.log_density(theta)
    possible = np.isfinite(weights)
    weights[possible] -= proposal.logpdf(theta)[possible]
    likelihoods = np.full(len(theta), -np.inf)
    likelihoods[possible] = log_likelihood(record, theta[possible])
    lower, upper = contrastive_bounds(likelihoods[None], weights[None])
    return InformationGain(float(lower[0]), float(upper[0]), posterior, _effective(likelihoods[1:] + weights[1:]))


def _effective(log_weights: Array) -> float:
    """Effective number of weighted draws (Kong, Liu & Wong 1994, J. Am. Stat. Assoc. 89:278)."""
    if not np.isfinite(log_weights).any():
        return 0.0
    return float(np.exp(2.0 * logsumexp(log_weights) - logsumexp(2.0 * log_weights)))
