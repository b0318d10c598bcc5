"""The agent's observation: the place and scale of each part. ``world.observation`` fills it."""

from __future__ import annotations

from typing import NamedTuple

from jawenv.base.errors import InputError
from jawenv.device.comfort import N_LIMITS
from jawenv.device.device import N_MOTORS

OBSERVATION_BOUND = 10.0
_BELIEF = ("belief_mean", "belief_sd")  # (mean - prior mean) / prior sd; log10(sd / prior sd); each per parameter
_REST_SIZES = {
    "pose": 5,  # filtered x, y / 5 mm; theta / 0.25 rad; psi, alpha / 0.1 rad
    "rates": 5,  # filtered x', y' / 20 mm/s; omega / 0.5 rad/s
    "jaw": 3,  # opening, side, fore-aft: signed used fractions of the soft limits, 0 at rest
    "jaw_range": 3,  # soft limits: opening / 30 mm, side / 10 mm, fore-aft / 10 mm
    "force": 6,  # load cell, body axes: force / 24 N, moment / (24 N x 20 mm)
    "motor_thrust": N_MOTORS,  # / full scale
    # Trajectory control: each motor's target less its position / 10 mm. Targets control: the channels' targets now, as
    # the guard leaves them. Force control: 0.
    "motor_target": N_MOTORS,
    "comfort_margin": N_LIMITS,  # 1 - used fraction, of the estimate
    "time_left": 1,  # share of the episode
}
POSE_SCALE = (0.005, 0.005, 0.25, 0.1, 0.1)
RATE_SCALE = (0.02, 0.02, 0.5, 0.5, 0.5)
RANGE_SCALE = (0.03, 0.01, 0.01)
FORCE_SCALE = 24.0
MOMENT_SCALE = FORCE_SCALE * 0.02
TARGET_SCALE = 0.01


class Parts(NamedTuple):
    """Parts of an environment's flat observation; policies, cards and the twin compare them by name.

    Where muscles are ``asked`` for, ``asked`` (1 or 0 for each) and ``discomfort`` (of the episode so far, s) follow
    the other parts; elsewhere, where the device keeps a ``budget`` of discomfort, ``spent`` (share of it, as the device
    takes it to be).
    """

    n_parameters: int = 12
    asked: bool = False
    budget: bool = False

    @property
    def layout(self) -> dict[str, slice]:
        """Slices of the parts of the flat observation: name -> slice."""
        layout, start = {}, 0
        end = {"asked": self.n_parameters // 2, "discomfort": 1} if self.asked else {"spent": 1} if self.budget else {}
        for name, size in (dict.fromkeys(_BELIEF, self.n_parameters) | _REST_SIZES | end).items():
            layout[name] = slice(start, start + size)
            start += size
        return layout

    @property
    def size(self) -> int:
        """Length of the flat observation."""
        return sum(part.stop - part.start for part in self.layout.values())

    def check(self, size: int, reader: object) -> None:
        """Make sure that an observation of this length has these parts, as its ``reader`` takes them to be."""
        if size != self.size:
            parts = f"{self.size}, of {', '.join(self.layout)}"
            told = "`take_world(env.unwrapped.configuration)` tells of an environment with other ones"
            raise InputError(f"{reader}: an observation has {size} values; allowed: {parts}; {told}")


OBSERVATION_LAYOUT = Parts().layout
"""The layout of ``jawenv/Jaw-v3``, with its 12 parameters."""

OBSERVATION_REST = Parts(0).layout
"""The layout behind the belief, counted from the belief's end."""
