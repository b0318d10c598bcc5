"""A belief that one treatment hands to the next: a normal one about the natural-log parameters, correlations included.

The filter of the environments starts from independent parameters (`jawenv.anatomy.Prior`), but treatments leave them
correlated. So the filter gets a *working prior* without correlations, and what it adds to that is added to the full
belief instead, in information form (as in federated filters: Carlson 1990, IEEE Trans. Aerosp. Electron. Syst. 26:517):

    P_1^-1 = P_0^-1 + (P^-1 - D^-1),    P_1^-1 m_1 = P_0^-1 m_0 + (P^-1 m - D^-1 m_D)

with (m_0, P_0) the full belief before, (m_D, D) the working prior, (m, P) what the filter believes, (m_1, P_1) the full
belief after. For a normal likelihood this is exact, whatever the working prior. The filter's likelihood is not quite
normal. It is evaluated best from a working prior as wide as that from which the filter starts elsewhere: after six
treatments of 5 s with `slow_opening` the mean NEES of 24 patients is 11.7 then, and 15.5 from one with the marginal sds
of the belief.

Where the anatomy is known only within sds, the belief is about x = (muscles, the patient's own anatomy). With beliefs
about the muscles alone, the errors that come of the anatomy would count as if they were independent from one treatment
to the next. The session's part (load cell, mouthpiece, tilt) is drawn anew for each treatment and integrated out in
each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eval.kept.entries import Entry
from jawenv.anatomy import Cohort, Prior
from jawenv.anatomy.knowledge import knowledge

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PatientBelief:
    """A normal belief about P natural-log parameters."""

    mean: Array  # (P,)
    cov: Array  # (P, P) positive definite

    @classmethod
    def of_prior(cls, prior: Prior) -> PatientBelief:
        """The belief of a cohort's prior, without correlations."""
        return cls(np.array(prior.mean), np.diag(np.square(prior.sd)))

    @property
    def sd(self) -> Array:
        """(P,) standard deviations."""
        return np.sqrt(np.diagonal(self.cov))

    def widened(self, sd: float) -> PatientBelief:
        """The belief after an independent normal step of that sd of every parameter."""
        return PatientBelief(self.mean, self.cov + sd**2 * np.eye(len(self.mean)))

    def working_prior(self, population: Prior) -> Prior:
        """The filter's start: the same means, the sds of the cohort's prior or larger ones, no correlations."""
        return Prior(self.mean, np.maximum(self.sd, population.sd))


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


@dataclass(frozen=True, eq=False, kw_only=True)
class KnownPatient(Cohort):
    """The cohort of a patient, with another prior for the filter."""

    believed: Prior  # the prior

    def __post_init__(self) -> None:
        """Put the prior in place of the cohort's own."""
        super().__post_init__()
        object.__setattr__(self, "_typical", self.prior.mean)
        object.__setattr__(self, "prior", self.believed)

    @property
    def typical(self) -> NDArray[np.float64]:
        """Typical parameters of the cohort: the filter integrates out as many numbers whatever is believed."""
        typical: NDArray[np.float64] = self.__dict__["_typical"]
        return typical

    @classmethod
    def of(cls, cohort: Cohort, believed: Prior) -> KnownPatient:
        """A cohort with another prior."""
        return cls(cohort.name, cohort.description, cohort.basis, cohort.groups, cohort.muscles, believed=believed)

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild with the prior."""
        return KnownPatient.of, (Cohort(self.name, self.description, self.basis, self.groups, self.muscles), self.prior)
