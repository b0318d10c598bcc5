"""Numbers to a maneuver that goes beside another one: offsets of its targets at knots, joined by straight lines.

A maneuver that was designed second by second has plans that do not see its end; a search over the whole of it does.
"""

from __future__ import annotations

import numpy as np

from agents.replay import followed, maneuver_of_targets
from jawenv.device.channels import CHANNELS, HIGHEST, LOWEST
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.signals import Keyframes
from jawenv.playing.protocol import Array
from training.search.sequential import RETURN_S

STEP_S = 0.2  # between targets of the maneuver that is made
KNOT_S = 0.4  # between knots
SIZE = np.array([0.25, 0.4, 0.1, 0.4])
"""What 1 of a number is, as a fraction of the patient's comfort, for each channel."""


class Knots:
    """A maneuver, and offsets of its targets until a horizon.

    Args:
        base: the maneuver.
        horizon_s: where the last knot lies.
        then: what follows after the horizon, reached within ``RETURN_S``; the maneuver itself by default.

    Attributes:
        start: (n,) zeros: the maneuver itself.
    """

    def __init__(self, base: Maneuver, horizon_s: float, then: Maneuver | None = None) -> None:
        self.base = base
        times: Array = STEP_S * np.arange(1.0, round(max(horizon_s, length_s(base)) / STEP_S) + 1)
        self._targets: Array = base.targets(times).value
        if then is not None:
            after = np.clip((times - horizon_s) / RETURN_S, 0.0, 1.0)[:, None]
            self._targets += after * (then.targets(times).value - self._targets)
        knots = KNOT_S * np.arange(1, max(1, round(horizon_s / KNOT_S)) + 1)
        self._weights = np.clip(1.0 - np.abs(times[:, None] - knots) / KNOT_S, 0.0, None)
        self.start = np.zeros(len(knots) * len(CHANNELS))

    def targets(self, numbers: Array) -> Array:
        """Targets (T, 4) every ``STEP_S``, as far and as fast as the device lets them, from any real numbers (n,)."""
        offsets = self._weights @ (np.reshape(numbers, (-1, len(CHANNELS))) * SIZE)
        goals = np.clip(self._targets + offsets, np.array(LOWEST), HIGHEST)
        path: Array = followed(goals[None], STEP_S)[0]
        return path

    def maneuver(self, numbers: Array, about: dict[str, str]) -> Maneuver:
        """The maneuver of numbers (n,), with name, title, description and source; it goes back to rest and repeats."""
        return maneuver_of_targets(self.targets(numbers), STEP_S, about, return_s=RETURN_S)


def length_s(maneuver: Maneuver) -> float:
    """How long a maneuver of keyframes lasts before it goes back to rest (s); 0 for one that has other signals."""
    signals = [maneuver.channels.signal(name) for name in CHANNELS]
    keyframes = [signal for signal in signals if isinstance(signal, Keyframes)]
    last = max((signal.points[-1].t_s for signal in keyframes), default=0.0)
    return max(0.0, last - RETURN_S) if len(keyframes) == len(signals) else 0.0
