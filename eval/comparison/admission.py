"""Admission to the ranking: entries within comfort, with a stated precision that can be believed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from eval.figures.catalogue import ADMITTED_S, PER_S
from jawenv.base.errors import InputError

FALSE_NEES = 4.0
"""Mean NEES per parameter above which sds are false: errors are more than twice what the filter states."""
LARGEST_RINGING = 0.05
"""Share of ringing episodes above which nothing counts as known; with a model that is right few ring."""


@dataclass(frozen=True)
class AdmissionLimits:
    """Largest cost to the patient of a ranked entry."""

    discomfort_s: float = ADMITTED_S  # largest mean discomfort, s per 30 s, >= 0
    violation: float = 0.01  # largest share of episodes that cross a hard limit, 0 to 1

    def __post_init__(self) -> None:
        """Check both values."""
        if not (math.isfinite(self.discomfort_s) and self.discomfort_s >= 0.0):
            raise InputError(f"largest-discomfort-s is {self.discomfort_s}; allowed: a finite number, 0 or more")
        if not 0.0 <= self.violation <= 1.0:
            raise InputError(f"largest-violation is {self.violation}; allowed: a share, 0 to 1")

    def reasons(self, discomfort_s: float, violation: float) -> list[str]:
        """The reasons against an entry, a phrase for each limit that it exceeds.

        Args:
            discomfort_s: its mean discomfort, s per 30 s.
            violation: share of its episodes that cross a hard limit.
        """
        reasons = []
        if discomfort_s > self.discomfort_s:
            reasons.append(f"discomfort {discomfort_s:.2g} s per {PER_S:g} s, allowed {self.discomfort_s:g}")
        if violation > self.violation:
            reasons.append(f"{violation:.1%} of the episodes cross a hard limit, allowed {self.violation:.1%}")
        return [reason.replace("%", " %") for reason in reasons]


def does_not_fit(ringing: float) -> str:
    """The reason that nothing counts as known, where readings contradict the model; else empty.

    Args:
        ringing: share of the episodes in which the alarm rings.
    """
    if ringing <= LARGEST_RINGING:
        return ""
    share, allowed = (f"{100.0 * value:.3g} %" for value in (ringing, LARGEST_RINGING))
    return f"the alarm rings in {share} of the episodes, allowed {allowed}: their readings do not fit the model"


def false_sd(nees: float, information_true: float, information_claimed: float, parameters: int) -> str:
    """The reason for disbelief in stated sds; empty where they can be believed.

    Args:
        nees: mean over the patients.
        information_true: mean, nats.
        information_claimed: mean, nats.
        parameters: how many there are, which is the mean NEES of a calibrated filter.
    """
    if nees > FALSE_NEES * parameters:
        return f"sds are false: errors are {math.sqrt(nees / parameters):.1f} times what the filter states"
    if information_true < 0.0 < information_claimed:
        return "sds are false: the truth is less likely than before anything was measured"
    return ""
