"""Where the mouthpiece is relative to the patient's rest pose and natural opening path."""

from __future__ import annotations

from jawenv.kernels.compiled import njit_inlined
from jawenv.mechanics.jaw import Jaw


@njit_inlined
def path_at(limits, opening):
    """Forward place of the mouthpiece (m) on the natural path, ``opening`` (m) above the rest opening."""
    s = opening / limits.opening
    return limits.path[0] + limits.path[1] * s + limits.path[2] * s * s


@njit_inlined
def excursions(limits, jaw: Jaw, point):
    """Opening above rest, side (+ left) and fore-aft excursion from the natural path (m) of the mouthpiece."""
    opening = jaw.mouthpiece[2] - point[2] - limits.rest_opening
    return opening, point[1] - limits.rest_side, point[0] - path_at(limits, opening)
