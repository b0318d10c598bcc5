"""Keeps a maneuver within a patient's comfort: targets shrink before a limit is used up."""

import numpy as np

from agents.maneuver import CHANNELS
from agents.observed import Observed
from agents.protocol import Array
from jawenv.device.comfort import COMFORT_LIMITS

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
FASTEST = {"opening": 0.4, "side": 0.5, "fore_aft": 2.0, "roll": 0.5}  # 1/s: shrinking is a movement too
REGROW = 0.01  # 1/s, back towards full size

_GUARD = np.array(
    [[GUARDS.get(limit, {}).get(channel, np.nan) for channel in CHANNELS] for limit in (*COMFORT_LIMITS, "crest")]
)
_FASTEST = np.array([FASTEST[channel] for channel in CHANNELS])


def comfortable_size(size: Array, seen: Observed, dt: float) -> Array:
    """What the targets of each channel are to be multiplied by next.

    A channel shrinks in proportion to what is missing of its guard, with the time constant `SHRINK_S` and no faster
    than `FASTEST`; it grows back slowly, so that a maneuver settles at what this patient tolerates.

    Args:
        size: (N, 4) as it was, 0 to 1.
        seen: N observations.
        dt: time since `size` was found, s.

    Returns:
        (N, 4).
    """
    margin = np.column_stack([seen.margin, 1.0 - seen.condyle / CREST_SHARE])
    allowed = np.fmin(1.0, np.clip(margin[:, :, None] / _GUARD, 0.0, 1.0)).min(axis=1)
    shrunk = size - np.minimum((size - allowed) * (1.0 - np.exp(-dt / SHRINK_S)), _FASTEST * dt)
    return np.where(allowed < size, shrunk, np.minimum(size + REGROW * dt, 1.0))
