"""Keeps targets within a patient's comfort: they shrink before a limit is used up.

They shrink by two factors. ``size`` is for every episode: little is left of a limit. ``budget.size`` is for an episode
with a budget of discomfort: the nearer its end, the more margin is asked for, and a channel that drives a limit beyond
it gives way, and its motors let go. The budget is spent by what the device takes the discomfort to be; it is never told
the true one.
"""

from __future__ import annotations

from math import exp
from typing import Annotated

import numpy as np

from jawenv.device.channels import CHANNELS, N_CHANNELS
from jawenv.device.comfort import COMFORT_LIMITS, N_LIMITS, SPEED
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype

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

# Which channels give way where a budget of discomfort asks for more margin of a limit.
DRIVERS: dict[str, tuple[str, ...]] = {
    "force": CHANNELS,
    "opening": ("opening",),
    "side": ("side", "roll"),
    "fore_aft": ("opening", "fore_aft"),
    "condyle_fore_aft": ("opening", "fore_aft"),
    "condyle_side": ("opening", "side", "roll"),
    "speed": CHANNELS,
    "tension": ("opening", "side"),
}
# Margin that is asked for: the first times the square of the spent share, at most the second. A jaw that has no more of
# it at rest would be held there for good.
ASKED_MARGIN = (0.6, 0.4)
# A margin counts as it will be in so many s, if it goes on falling as it does. Opening and side end where their targets
# do, so half as long; the speed shakes, and counts as it is.
LOOK_AHEAD_S = dict.fromkeys(COMFORT_LIMITS, 0.2) | {"opening": 0.1, "side": 0.1, "speed": 0.0}
GIVING_WAY = 0.1  # of margin: so much less than is asked for takes a channel back as fast as it may
BRAKE = 5.0  # 1/s, of a channel's size then
FASTEST_BRAKE = 4.0  # times ``FASTEST``
RECOVERY = 0.5  # 1/s, back towards full size
# 1/s, by which motors let go of their thrust where so much margin is missing now. Targets alone do not take a jaw back:
# soft servos hold a stiff one by a thrust that grew over a second, and push it aside as its muscles slacken.
RELEASE = 4.0

_LIMITS = (*COMFORT_LIMITS, "crest")
_GUARD = np.array([[GUARDS.get(limit, {}).get(channel, np.inf) for channel in CHANNELS] for limit in _LIMITS])
_AHEAD_S = np.array(list(LOOK_AHEAD_S.values()))
_DRIVES = np.array([[channel in DRIVERS[limit] for channel in CHANNELS] for limit in COMFORT_LIMITS])


class _Budget:
    """An episode's budget of discomfort, as the guard keeps it."""

    total: float  # s of discomfort of 1; 0 for no budget
    spent: float  # s
    hard: Annotated[Array, N_LIMITS]  # limits over the soft ones
    margin: Annotated[Array, N_LIMITS]  # as last seen
    size: Annotated[Array, N_CHANNELS]  # what the targets are multiplied by, 0 to 1
    release: Annotated[Array, N_CHANNELS]  # 1/s, at which motors let go


class Tracker:
    """State of the law of targets."""

    target: Annotated[Array, N_CHANNELS]  # fractions, before the guard
    rate: Annotated[Array, N_CHANNELS]  # 1/s, at which they move
    size: Annotated[Array, N_CHANNELS]  # what the guard multiplies them by, 0 to 1
    budget: _Budget
    integral: Annotated[Array, 3]  # of the force law: N, N m, N m
    rest_roll: float  # rad, as first seen
    crest: float  # m, the eminence's; 0 for that of the default anatomy
    full_force: float  # N, of the fore-aft channel
    begun: bool


TRACKER = record_dtype(Tracker)
"""The device's memory while it follows targets."""


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


@njit
def keep_budget(budget: _Budget, margin, dt):
    """Spend the budget by the discomfort of a moment, and change its ``size`` and ``release``.

    Args:
        budget: record of ``_Budget``.
        margin: (8,) what is left of each comfort limit.
        dt: s since it was last changed.
    """
    for limit in range(N_LIMITS):
        budget.spent += dt * max(-margin[limit], 0.0) / (budget.hard[limit] - 1.0)
    asked = min(ASKED_MARGIN[0] * (budget.spent / budget.total) ** 2, ASKED_MARGIN[1])
    for channel in range(N_CHANNELS):
        lack = passed = 0.0
        for limit in range(N_LIMITS):
            if _DRIVES[limit, channel]:
                falls = min(margin[limit] - budget.margin[limit], 0.0)
                left = margin[limit] + _AHEAD_S[limit] / dt * falls
                lack = max(lack, min((asked - left) / GIVING_WAY, 1.0))
                if limit != SPEED:  # to let go is to move
                    passed = max(passed, min((asked - margin[limit]) / GIVING_WAY, 1.0))
        budget.release[channel] = RELEASE * passed
        if lack > 0.0:
            fastest = FASTEST_BRAKE * FASTEST[channel] * dt
            budget.size[channel] -= min(budget.size[channel] * lack * BRAKE * dt, fastest)
        else:
            budget.size[channel] = min(budget.size[channel] + RECOVERY * dt, 1.0)
    budget.margin[:] = margin
