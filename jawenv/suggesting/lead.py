"""A movement that begins where a recording ends: before it, targets lead the jaw back to rest."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from jawenv.ladder import DEFAULT_ENV
from jawenv.playing.agents import Array
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.written import maneuver_of_targets
from jawenv.recordings.record import Record

_ROWS, _OFF_M = 10, 3e-3
"""Rows of a recording's beginning and end; distance from rest from which the jaw is led back."""
_PER_S = (0.5, 1.0)
"""Rates of opening and side, shares of the patient's comfort; targets may change by 0.9 and 3."""
_STEP_S = 0.2


def led_back(record: Record, suggestion: Any) -> tuple[Maneuver, str]:
    """The maneuver of a suggestion from where the recording ends, and what is before it in words.

    It is the maneuver itself, and no words, where the jaw is at rest there.
    """
    moved, full = _from_rest(record, suggestion)
    if np.linalg.norm(moved) <= _OFF_M:
        return suggestion.maneuver, ""
    lead = _lead((moved / full).clip([0.0, -1.0], 1.0))
    given: Maneuver = suggestion.maneuver
    goals = given.targets(_STEP_S * np.arange(1, round(suggestion.seconds / _STEP_S) + 1)).value
    header = {name: str(getattr(given, name)) for name in ("name", "title", "description", "source")}
    far_mm, lasts_s = 1e3 * np.linalg.norm(moved), _STEP_S * len(lead)
    words = f"; before it the jaw is led back to rest, {far_mm:.0f} mm in {lasts_s:.1f} s"
    return maneuver_of_targets(np.concatenate([lead, goals]), _STEP_S, header), words


def _from_rest(record: Record, suggestion: Any) -> tuple[Array, Array]:
    """Opening and side (2,), m, at the end of a recording, and what they are at most, of the believed patient.

    The side is counted from the first rows: where the mouthpiece sits is not known better than that.
    """
    env: Any = gym.make_vec(DEFAULT_ENV, 1, **suggestion.world)
    env.reset(seed=suggestion.seed, options={"patients": [suggestion.patient]})
    limits = env.unwrapped.simulation.worlds["known"]["limits"][0]
    env.close()
    places = np.ma.masked_invalid(record.measured[:, :3])  # a file may lack some
    first, last = places[:_ROWS].mean(axis=0), places[-_ROWS:].mean(axis=0)
    opening = record.jaw["mouthpiece"][2] - limits["rest_opening"] - last[2]
    moved = np.ma.stack([np.ma.maximum(opening, 0.0), last[1] - first[1]]).filled(0.0)
    return moved, np.array([limits["opening"], limits["side"]])


def _lead(shares: Array) -> Array:
    """Targets (T, 4) from there to rest, on a line."""
    steps = max(1, int(np.ceil((np.abs(shares) / _PER_S).max() / _STEP_S)))
    lead = np.zeros((steps + 1, 4))
    lead[:, :2] = np.linspace(shares, 0.0, steps + 1)
    return lead
