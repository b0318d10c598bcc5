"""The verdict on a muscle: normal, stiff, blocked, or not known yet, each with its probability; or none."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr
from scipy.stats import multivariate_normal

from jawenv.metrics.diagnosis import BLOCKED_B, CONFIDENCE, MEASURED, STIFF_F_O_N

Array = NDArray[np.float64]

NORMAL, STIFF, BLOCKED, BOTH, UNKNOWN = "normal", "stiff", "blocked", "stiff and blocked", "not known yet"
NOT_MEASURED = "not measured"
"""The prior decides: the error bars are above ``MEASURED`` of its sds."""
NO_VERDICT = "no verdict"
"""The readings do not fit the model."""
FINDINGS = (STIFF, BLOCKED, BOTH, NORMAL)
OPEN = (UNKNOWN, NOT_MEASURED)
WORDS = (NORMAL, STIFF, BLOCKED, BOTH, *OPEN)


@dataclass(frozen=True)
class Verdict:
    """The verdict on one muscle."""

    word: str  # one of ``WORDS``, or ``NO_VERDICT``
    probability: float  # that the word is right; of the likeliest where nothing is known yet
    likeliest: str  # the one of `normal`, `stiff`, `blocked`, `stiff and blocked` with the largest probability
    stiff: float  # probability that F_o is raised
    blocked: float  # probability that b is raised
    both: float  # probability that both are

    def chance_of(self, word: str) -> float:
        """Probability of a finding: of a raised F_o for `stiff` and of a raised b for `blocked`, whatever the other."""
        chances = {STIFF: self.stiff, BLOCKED: self.blocked, BOTH: self.both}
        return chances.get(word, max(1.0 - self.stiff - self.blocked + self.both, 0.0))

    @property
    def open_question(self) -> str:
        """A second possible finding beside a verdict of stiff or blocked; empty where none is left."""
        other = {STIFF: self.blocked, BLOCKED: self.stiff}.get(self.word, 0.0)
        if other <= 1.0 - CONFIDENCE:
            return ""
        return BLOCKED if self.word == STIFF else STIFF


WITHHELD = Verdict(NO_VERDICT, math.nan, "", math.nan, math.nan, math.nan)
"""The verdict on a muscle of which nothing is said; its probabilities are NaN."""


def verdict(mean: Array, cov: Array, prior_sd: Array | None = None) -> Verdict:
    """The verdict on one whole muscle.

    It is stiff when the posterior probability of a raised F_o reaches ``CONFIDENCE``, blocked when that of a raised b
    does, normal when that of neither does. The two are correlated, so that probabilities are those of the joint normal
    distribution. A parameter whose error bar is above ``MEASURED`` of the prior's decides nothing.

    Args:
        mean: (2,) of log F_o and log b.
        cov: (2, 2).
        prior_sd: (2,) of the prior; None lets the prior speak.
    """
    measured = [True, True] if prior_sd is None else (np.sqrt(np.diagonal(cov)) <= MEASURED * prior_sd).tolist()
    above = (mean - np.log([STIFF_F_O_N, BLOCKED_B])) / np.sqrt(np.diagonal(cov))
    stiff, blocked = (float(share) for share in ndtr(above))
    correlation = cov[0, 1] / np.sqrt(cov[0, 0] * cov[1, 1])
    both = float(multivariate_normal.cdf(above, cov=[[1.0, correlation], [correlation, 1.0]], allow_singular=True))
    neither = max(1.0 - stiff - blocked + both, 0.0)
    shares = {NORMAL: neither, STIFF: stiff - both, BLOCKED: blocked - both, BOTH: both}
    likeliest = max(shares, key=lambda word: shares[word])
    is_stiff, is_blocked = stiff >= CONFIDENCE and measured[0], blocked >= CONFIDENCE and measured[1]
    if is_stiff and is_blocked:
        word, probability = BOTH, both
    elif is_stiff:
        word, probability = STIFF, stiff
    elif is_blocked:
        word, probability = BLOCKED, blocked
    elif neither >= CONFIDENCE and all(measured):
        word, probability = NORMAL, neither
    else:
        word, probability = UNKNOWN if all(measured) else NOT_MEASURED, shares[likeliest]
    return Verdict(word, probability, likeliest, stiff, blocked, both)


def verdicts(mean: Array, cov: Array, prior_sd: Array | None = None) -> list[Verdict]:
    """The verdict on every muscle.

    Args:
        mean: (2 M,) log F_o and log b of each.
        cov: (2 M, 2 M).
        prior_sd: (2 M,) as of ``verdict``.
    """
    pairs = (slice(2 * i, 2 * i + 2) for i in range(len(mean) // 2))
    return [verdict(mean[pair], cov[pair, pair], None if prior_sd is None else prior_sd[pair]) for pair in pairs]


def truly(log_parameters: Array) -> str:
    """The word that is right for a muscle with these log F_o and log b."""
    stiff, blocked = np.exp(log_parameters) > [STIFF_F_O_N, BLOCKED_B]
    return {(False, False): NORMAL, (True, False): STIFF, (False, True): BLOCKED, (True, True): BOTH}[stiff, blocked]
