"""Keeps targets within a patient's comfort: they shrink before a limit is used up."""

from __future__ import annotations

from math import exp

import numpy as np

from jawenv.device.channels import CHANNELS, N_CHANNELS
from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.kernels.compiled import njit

# Which channels shrink when little is left of a limit, and the margin below which they begin to. Opening and side are
# no limits here: the targets themselves stay within them. Nor is speed: the unmodelled force alone shakes the jaw to
# its soft limit now and then. The crest of the eminence is no comfort limit, but near it a jaw under pure force snaps
# open (the fold of its equilibrium).
GUARDS: dict[str, dict[str, float]] = {
    "force": {"opening": 0.2, "side": 0.2, "fore_aft": 0.2, "roll": 0.2},
    "fore_aft": {"fore_aft": 0.35},
    "condyle_fore_aft": {"fore_aft": 0.35},
    "condyle_side": {"side": 0.2},
    "tension": {"opening": 0.1, "side": 0.1},
    "crest": {"opening": 0.3, "fore_aft": 0.4},
}
CREST_SHARE = 0.8  # of the condyles' way to the crest: no margin is left there
SHRINK_S = 0.3  # time constant
FASTEST = (0.4, 0.5, 2.0, 0.5)  # 1/s, by channel: shrinking is a movement too
REGROW = 0.01  # 1/s, back towards full size

_LIMITS = (*COMFORT_LIMITS, "crest")
_GUARD = np.array([[GUARDS.get(limit, {}).get(channel, np.inf) for channel in CHANNELS] for limit in _LIMITS])


@njit
def shrink(size, margin, crest_margin, dt):
    """Change ``size`` (4), what the targets of each channel are multiplied by.

    A channel shrinks in proportion to what is missing of its guard, with the time constant ``SHRINK_S`` and no faster
    than ``FASTEST``; it grows back slowly, so that a maneuver settles at what this patient tolerates.

    Args:
        size: (4,) as it was, 0 to 1; changed in place.
        margin: (8,) what is left of each comfort limit.
        crest_margin: the same of the condyles' way to the crest.
        dt: s since ``size`` was last changed.
    """
    for channel in range(N_CHANNELS):
        allowed = 1.0
        for limit in range(_GUARD.shape[0]):
            if _GUARD[limit, channel] < np.inf:
                left = margin[limit] if limit < margin.shape[0] else crest_margin
                allowed = min(allowed, max(0.0, left / _GUARD[limit, channel]))
        if allowed < size[channel]:
            step = (size[channel] - allowed) * (1.0 - exp(-dt / SHRINK_S))
            size[channel] -= min(step, FASTEST[channel] * dt)
        else:
            size[channel] = min(size[channel] + REGROW * dt, 1.0)
