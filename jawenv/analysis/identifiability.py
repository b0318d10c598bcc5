"""Identifiability of a record's parameters: information, least-known combinations, collinearity.

All of it follows from the bound along the record's motion: it is about the maneuver and the device, and not about any
estimator. Parameters are natural logs: a direction's sd of 0.05 is 5 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jawenv.analysis.bound import bound_along
from jawenv.analysis.wording import in_words
from jawenv.base.errors import InputError
from jawenv.recordings.record import Record

Array = NDArray[np.float64]
# Brun et al. (2001) call parameters of a collinearity index above 10 to 15 poorly identifiable together.
COLLINEAR = 10.0


def data_information(covariance: Array, prior_sd: Array) -> Array:
    """Information (p, p) about the parameters that came from the data alone: P^-1 without the prior's.

    Taken in units of the prior's sds, where rounding hurts least. The motion and all noise are integrated out. Exact
    if the load cell has no gain error; one that is considered (Schmidt 1966) makes the data's share depend a little on
    the prior.

    Args:
        covariance: (p, p) posterior, as ``Bound.cov[-1]``.
        prior_sd: (p,) of independent priors.
    """
    size = np.outer(prior_sd, prior_sd)
    gained = np.linalg.inv(covariance / size) - np.eye(len(prior_sd))
    return np.asarray(0.5 * (gained + gained.T) / size, dtype=np.float64)


def collinearity(information: Array, subsets: ArrayLike) -> Array:
    """Collinearity indices gamma_K of some parameters (Brun, Reichert & Kuensch 2001, Water Resour. Res. 37:1015).

    1 / sqrt(smallest eigenvalue of S~^T S~), with S~ the sensitivities of the chosen parameters, each of length 1. Here
    S^T S is the data's information, in which motion and noise are integrated out. It is 1 for parameters whose effects
    have nothing in common; at gamma, a change of one parameter can be made up for by the others to 1 / gamma of its
    effect. Other parameters than the chosen count as known.

    Args:
        information: (p, p) of the data alone.
        subsets: (M, k) numbers of the chosen parameters.

    Returns:
        (M,) 1 or more; infinite if the data do not see one of them, or cannot tell them apart at all.
    """
    chosen = np.asarray(subsets)
    length = np.sqrt(np.maximum(np.diag(information), 0.0))
    scale = np.where(length > 0.0, length, 1.0)
    unit = information / np.outer(scale, scale)
    smallest = np.linalg.eigvalsh(unit[chosen[:, :, None], chosen[:, None, :]])[:, 0]
    smallest[(length[chosen] == 0.0).any(axis=1)] = 0.0
    # Below rounding there is no telling how small it is.
    rounding = chosen.shape[1] * np.finfo(float).eps
    return np.where(smallest > rounding, 1.0 / np.sqrt(np.maximum(smallest, rounding)), np.inf)


@dataclass(frozen=True, eq=False)
class _Combination:
    """A direction in the space of the p natural-log parameters."""

    direction: Array  # (p,) of length 1
    sd: float  # the posterior's along it
    prior_sd: float  # the prior's along it
    words: str  # what it is about


@dataclass(frozen=True, eq=False)
class Identifiability:
    """The information of a record about p natural-log parameters, independent of the estimator."""

    parameter_names: tuple[str, ...]  # p names
    duration_s: float  # of the record, s
    covariance: Array  # (p, p) bound at its end
    prior_sd: Array  # (p,) before the record
    information: Array  # (p, p) from the data alone

    @property
    def sd(self) -> Array:
        """(p,) bound of each parameter's standard deviation."""
        return np.sqrt(np.diag(self.covariance))

    @cached_property
    def spectrum(self) -> Array:
        """(p,) eigenvalues of the data's information, largest first; 1 / sqrt of one is the data's own sd."""
        return np.asarray(np.linalg.eigvalsh(self.information)[::-1], dtype=np.float64)

    @property
    def collinearity(self) -> float:
        """Collinearity index of all parameters together."""
        return float(collinearity(self.information, [range(len(self.prior_sd))])[0])

    def least_known(self, number: int = 1) -> list[_Combination]:
        """The directions with the largest posterior sd, largest first.

        Args:
            number: how many, 1 to p.
        """
        size = len(self.prior_sd)
        if not 1 <= number <= size:
            raise InputError(f"number is {number}; allowed: 1 to {size}")
        values, vectors = np.linalg.eigh(self.covariance)
        return [
            _Combination(
                direction=vectors[:, i],
                sd=float(np.sqrt(values[i])),
                prior_sd=float(np.linalg.norm(vectors[:, i] * self.prior_sd)),
                words=in_words(vectors[:, i], self.parameter_names),
            )
            for i in range(size - 1, size - 1 - number, -1)
        ]

    def describe(self) -> str:
        """A few lines for a person."""
        size = len(self.prior_sd)
        nats = float(np.log(self.prior_sd).sum() - 0.5 * np.linalg.slogdet(self.covariance)[1])
        worst = int(np.argmax(self.sd))
        determined = int((self.spectrum * np.mean(self.prior_sd**2) > 1.0).sum())
        lines = [
            f"{self.duration_s:g} s, {size} parameters: {nats:.1f} nats at most",
            f"worst parameter: {self.parameter_names[worst]}, sd {self.sd[worst]:.1%}",
            "least-known combinations:",
            *(f"  {row.words}: sd {row.sd:.1%} (prior {row.prior_sd:.0%})" for row in self.least_known(min(3, size))),
            f"directions of which the data say more than the prior: {determined} of {size}",
            f"collinearity index of all: {self.collinearity:.1f}",
        ]
        if size > 1:
            pairs = list(combinations(range(size), 2))
            indices = collinearity(self.information, pairs)
            first, second = (self.parameter_names[i] for i in pairs[int(indices.argmax())])
            verdict = "hard to tell apart" if indices.max() > COLLINEAR else "can be told apart"
            lines.append(f"most collinear pair: {first} and {second}, index {indices.max():.1f}, {verdict}")
        return "\n".join(lines)


def identifiability(record: Record) -> Identifiability:
    """The identifiability of a record's parameters, at its ``truth`` and ``states``, see ``bound.bound_along``.

    Raises:
        InputError: as ``bound_along``.
    """
    bound = bound_along(record, every=len(record.time) - 1)
    return Identifiability(
        parameter_names=record.parameter_names,
        duration_s=float(record.time[-1] - record.time[0]),
        covariance=bound.cov[-1],
        prior_sd=bound.prior_sd,
        information=data_information(bound.cov[-1], bound.prior_sd),
    )
