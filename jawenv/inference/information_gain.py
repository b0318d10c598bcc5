"""Expected information gain in the units of Bayesian experimental design: bounds that any design can be given."""

from __future__ import annotations

from math import log

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import logsumexp

from jawenv.base.errors import InputError
from jawenv.inference.settings import Array


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
