"""Steering of the jaw: a hand, or a maneuver or agent that may be taken over and given back at any time."""

from __future__ import annotations

import numpy as np

from jawenv.base.errors import InputError, shown
from jawenv.controls import Control
from jawenv.device.channels import CHANNELS, FASTEST_TARGET, HIGHEST, LOWEST
from jawenv.live.deciding import Deciding
from jawenv.playing.agents import Action, Array, Mask, Memory, Observation
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.maneuvers.maneuver import Channels, Targets
from jawenv.playing.maneuvers.signals import KeyframePoint, Keyframes

_ZERO = Keyframes(kind="keyframes", points=(KeyframePoint(t_s=0.0, value=0.0),))
# The hand has all four channels, the roll among them.
_BY_HAND = Maneuver(
    name="by_hand",
    title="By hand",
    description="Targets that a person sets.",
    source="jawenv live",
    channels=Channels(opening=_ZERO, roll=_ZERO),
)


class Steering(Player):
    """An agent of one world whose targets come from a hand, a maneuver or another agent, in every control mode.

    Args:
        control: control mode of the environment.
        control_hz: control steps per second of the environment.

    Attributes:
        hand: (4,) where the hand wants the jaw, as fractions of the patient's comfort; see ``channels.CHANNELS``.
        asked: (4,) what was asked for in the last step, by whoever drove.
        driver: the maneuver or agent that drives; None while the hand does.
    """

    def __init__(self, control: Control, control_hz: float) -> None:
        super().__init__(_BY_HAND, control=control, control_hz=control_hz)
        self.hand: Array = np.zeros(len(CHANNELS))
        self.asked: Array = np.zeros(len(CHANNELS))
        self.driver: Maneuver | Deciding | None = None

    def set_hand(self, targets: object) -> None:
        """Say where the hand wants the jaw.

        Args:
            targets: (4,) fractions: opening 0 to 1, side, fore-aft and roll -1 to 1.
        """
        try:
            values = np.array(targets, dtype=np.float64)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape != (len(CHANNELS),):
            raise InputError(f"targets is {shown(targets)}; allowed: {len(CHANNELS)} numbers")
        for name, value, low in zip(CHANNELS, values.tolist(), LOWEST, strict=True):
            if not low - 1e-9 <= value <= HIGHEST + 1e-9:
                raise InputError(f"{name} is {value:g}; allowed: {low:g} to {HIGHEST:g}")
        self.hand = values

    def targets(self, time: Array) -> Targets:
        """See `Player.targets`; the hand's move no faster than the device moves them."""
        if isinstance(self.driver, Maneuver):
            targets = self.driver.targets(time)
        else:
            value = self._by_hand() if self.driver is None else self.driver.next(self._seen, self.asked)
            targets = Targets(value[None], (value - self.asked)[None] / self._dt)
        self.asked = targets.value[0]
        return targets

    def _by_hand(self) -> Array:
        reach = np.array(FASTEST_TARGET) * self._dt
        value: Array = self.asked + np.clip(self.hand - self.asked, -reach, reach)
        return value

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        self._seen = rows[0]
        return super()._decide(rows, memory, starts, deterministic)
