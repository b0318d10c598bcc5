"""Would the posterior have led to the right diagnosis of each muscle?

A muscle is *stiff* when its force at closed jaw F_o is raised and *blocked* when its exponential
stiffening b is raised. The posterior decides only when it is sure enough; a muscle left undecided counts as
missed, both for sensitivity and for specificity (3 x 2 table, intention to diagnose: Schuetz, Schlattmann &
Dewey 2012, BMJ 345:e6717). So an estimator that learns nothing scores 0 on both, not a free 100 %
specificity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jawenv.anatomy.muscles import known_muscle_sets
from jawenv.base.errors import InputError

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Half way, in logs, between the cohorts healthy and trismus, and between trismus and blockage.
STIFF_F_O_N = 1.7
BLOCKED_B = 14.0
CONFIDENCE = 0.95
MEASURED = 0.5
"""Share of the prior's error bar up to which the data speak."""


@dataclass(frozen=True)
class Diagnosis:
    """Decisions on one property ('stiff' or 'blocked') of M muscles in N patients."""

    raised: Mask  # (N, M) whether it truly is above the threshold
    called_raised: Mask  # (N, M) the posterior is sure that it is
    called_normal: Mask  # (N, M) the posterior is sure that it is not

    @property
    def sensitivity(self) -> float:
        """Share of truly raised muscles that are called raised; NaN when there is none."""
        return _share(self.called_raised, self.raised)

    @property
    def specificity(self) -> float:
        """Share of truly normal muscles that are called normal; NaN when there is none."""
        return _share(self.called_normal, ~self.raised)

    @property
    def undecided(self) -> float:
        """Share of all muscles on which the posterior is not sure."""
        return float(np.mean(~(self.called_raised | self.called_normal)))

    @property
    def wrong(self) -> float:
        """Share of the decided muscles that are decided wrongly; NaN when none is decided."""
        mistaken = (self.called_raised & ~self.raised) | (self.called_normal & self.raised)
        return _share(mistaken, self.called_raised | self.called_normal)


def _share(hits: Mask, decided: Mask) -> float:
    return float(np.mean(hits[decided])) if decided.any() else float("nan")


def whole_muscles_per_line(parameter_names: Sequence[str]) -> float:
    """Number of whole muscles that a line of the model with these parameters stands for; thresholds of F_o take it.

    One half for portions, two for left and right together; 1 for parameters of no model of jawenv.
    """
    ratios = {muscles.parameter_names: muscles.whole_muscles_per_line for muscles in known_muscle_sets().values()}
    return ratios.get(tuple(parameter_names), 1.0)


def diagnose(truth: Array, mean: Array, sd: Array, threshold: float, confidence: float = CONFIDENCE) -> Diagnosis:
    """Compare one log-parameter of every muscle with a threshold, at the posterior's own confidence.

    Args:
        truth: (N, M) natural logs of F_o, or of b.
        mean: (N, M) of the posterior.
        sd: (N, M) of the posterior.
        threshold: of the parameter itself (N for F_o), > 0.
        confidence: posterior probability from which on a muscle counts as decided, in [0.5, 1).

    Returns:
        The decisions.
    """
    from scipy.special import ndtri

    if not threshold > 0.0:
        raise InputError(f"threshold is {threshold}; allowed: a value above 0")
    if not 0.5 <= confidence < 1.0:
        raise InputError(f"confidence is {confidence}; allowed: at least 0.5 and below 1")
    log_threshold, sure = np.log(threshold), float(ndtri(confidence))
    distance = (mean - log_threshold) / sd
    return Diagnosis(raised=truth > log_threshold, called_raised=distance > sure, called_normal=distance < -sure)
