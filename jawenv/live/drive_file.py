"""A drive as a maneuver file: samples at times, linear between."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jawenv.base.errors import InputError
from jawenv.device.channels import CHANNELS
from jawenv.playing.agents import Array
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import Channels
from jawenv.playing.maneuvers.signals import KeyframePoint, Keyframes

_DECIMALS = 5
_SMALLEST = 10.0**-_DECIMALS
_FADE_IN_S = 0.001  # the samples begin at rest themselves


def maneuver_of_drive(name: str, times: Sequence[float], targets: Sequence[Array]) -> Maneuver:
    """The maneuver that asks for the same targets at the same times.

    Args:
        name: of the maneuver, lower case with underscores.
        times: when each was to be reached, s, increasing and above 0.
        targets: (4,) each, as fractions of the patient's comfort.
    """
    if not times:
        raise InputError("drive: nothing was driven; allowed: one step or more")
    at = np.array([0.0, *times])
    values = np.vstack([np.zeros(len(CHANNELS)), np.array(targets)])
    signals = {name: _samples(at, values[:, i]) for i, name in enumerate(CHANNELS)}
    return Maneuver(
        name=name,
        title=name.replace("_", " ").capitalize(),
        description=f"Driven by hand for {at[-1]:g} s.",
        source="jawenv live",
        fade_in_s=_FADE_IN_S,
        channels=Channels(**signals),
    )


def _samples(times: Array, values: Array) -> Keyframes:
    """The samples, less all that lie on the straight line between their neighbours."""
    indices = [0]
    for i in range(1, len(times) - 1):
        before, after = indices[-1], i + 1
        share = (times[i] - times[before]) / (times[after] - times[before])
        line = values[before] + share * (values[after] - values[before])
        if abs(values[i] - line) > _SMALLEST or not _straight(times, values, before, i, after):
            indices.append(i)
    indices.append(len(times) - 1)
    points = [KeyframePoint(t_s=round(float(times[i]), 6), value=round(float(values[i]), _DECIMALS)) for i in indices]
    return Keyframes(kind="keyframes", interpolation="linear", points=tuple(points))


def _straight(times: Array, values: Array, first: int, last: int, after: int) -> bool:
    """Whether all samples between ``first`` and ``last`` lie on the line from ``first`` to ``after``."""
    share = (times[first : last + 1] - times[first]) / (times[after] - times[first])
    line = values[first] + share * (values[after] - values[first])
    return bool(np.abs(values[first : last + 1] - line).max() <= _SMALLEST)
