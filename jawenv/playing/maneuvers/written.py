"""Maneuvers written down: targets at the ends of steps, joined by straight lines, and their files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from jawenv.base.errors import InputError, shown
from jawenv.base.files import write_text
from jawenv.device.channels import CHANNELS
from jawenv.playing.agents import Array
from jawenv.playing.maneuvers.maneuver import Maneuver

_FADE_IN_S = 1e-3  # a maneuver has to fade in; this one does before its first target
_DIGITS = 5
_STRAIGHT = 1e-6  # a point that is off the line between its neighbours by less is left out


def maneuver_of_targets(targets: Array, period: float, header: dict[str, str]) -> Maneuver:
    """The maneuver that reaches targets (T, 4) at the ends of the steps.

    Args:
        targets: fractions of the patient's comfort.
        period: length of a step, s.
        header: name, title, description and source.
    """
    channels = {channel: _keyframes(targets[:, k], period) for k, channel in enumerate(CHANNELS)}
    return Maneuver.model_validate({**header, "fade_in_s": _FADE_IN_S, "channels": channels})


def _keyframes(values: Array, period: float) -> dict[str, Any]:
    """A channel that begins at rest and reaches ``values`` (T,) at the ends of the steps."""
    path = np.append(0.0, values)
    bends = np.abs(np.diff(path, n=2)) > _STRAIGHT
    steps = np.flatnonzero(np.concatenate([[True], bends, [True]]))
    points = [{"t_s": round(k * period, 6), "value": round(float(path[k]), _DIGITS)} for k in steps]
    return {"kind": "keyframes", "interpolation": "linear", "points": points}


def save_maneuver(maneuver: Maneuver, path: Path) -> Path:
    """Write a maneuver file (YAML), either whole or not at all; returns its path."""
    if path.suffix != ".yaml":
        raise InputError(f"output is {shown(str(path))}; allowed: a file that ends in .yaml")
    text = yaml.safe_dump(maneuver.model_dump(mode="json"), sort_keys=False, default_flow_style=None, width=120)
    write_text(path, text)
    return path
