"""The law of the patients whom an environment draws, as a density: the prior of Bayesian design."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import log

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import logsumexp, ndtr

from jawenv.anatomy import Cohort
from jawenv.anatomy import cohort as cohort_of
from jawenv.anatomy.cohorts import TRUNCATION_SD
from jawenv.base.files import Source
from jawenv.inference.settings import DEFAULT_ENV, Array, configuration_of, log_parameters
from jawenv.inference.treatable import treatable

DRAWS = 20_000
"""By which the share of the treatable is known to 1 %, and the entropy to 0.02 nats."""


@dataclass(frozen=True, eq=False)
class PatientLaw:
    """The joint law of the patients whom ``reset`` draws: a cohort's, of those whom the device can treat."""

    cohort: Cohort
    """With the muscles of the environment's model, p parameters."""
    env_id: str
    """The environment."""
    share: float
    """Share of the cohort that the device can treat, in (0, 1], estimated."""
    entropy: float
    """Differential, of the natural-log parameters, nats, estimated."""

    @classmethod
    def of(
        cls, cohort: str | Cohort | Source = "trismus", *, env_id: str = DEFAULT_ENV, draws: int = DRAWS, seed: int = 0
    ) -> PatientLaw:
        """The law of an environment's patients.

        Args:
            cohort: as the environment's argument.
            env_id: an environment of jawenv.
            draws: of the cohort, by which share and entropy are estimated.
            seed: of these.

        Raises:
            InputError: an unknown cohort or id, or hardly anybody can be treated.
        """
        whole = cohort_of(cohort, configuration_of(env_id, None, {}).build_cohort().muscles)
        drawn = whole.sample(draws, seed)
        treated = drawn[treatable(drawn, env_id=env_id)]
        if not len(treated):
            treated = whole.sample(1, seed, accept=partial(treatable, env_id=env_id))
        share = len(treated) / max(draws, 1)
        return cls(whole, env_id, share, float(log(share) - _log_density(whole, treated).mean()))

    def sample(self, n: int, seed: int) -> Array:
        """(n, p) natural-log parameters of patients, other ones than those of an environment with this seed."""
        return self.cohort.sample(n, seed, accept=partial(treatable, env_id=self.env_id))

    def log_density(self, theta: ArrayLike) -> Array:
        """Log-density of natural-log parameters.

        Args:
            theta: (n, p).

        Returns:
            (n,) nats; -inf where the cohort has nobody, or the device cannot treat them.

        Raises:
            InputError: another shape, or parameters that are not finite.
        """
        rows = log_parameters(theta, self.cohort.mean.shape[1])
        density = _log_density(self.cohort, rows) - log(self.share)
        possible = np.isfinite(density)
        density[possible] = np.where(treatable(rows[possible], env_id=self.env_id), density[possible], -np.inf)
        return density


def _log_density(cohort: Cohort, theta: Array) -> Array:
    """(n,) of the whole cohort: equally likely groups of independent normal laws, truncated."""
    standard = (theta - cohort.mean[:, None]) / cohort.sd[:, None]  # (groups, n, p)
    inside = (np.abs(standard) <= TRUNCATION_SD).all(axis=-1)
    scale = cohort.sd * np.sqrt(2.0 * np.pi) * (1.0 - 2.0 * ndtr(-TRUNCATION_SD))
    terms = -0.5 * (standard**2).sum(axis=-1) - np.log(scale).sum(axis=-1)[:, None]
    density: Array = logsumexp(np.where(inside, terms, -np.inf), axis=0) - log(len(cohort.mean))
    return density
