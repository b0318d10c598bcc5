"""A maneuver: targets over time for the jaw's channels, read from a file that a user can write too."""

from functools import cached_property
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from jawenv.device.channels import CHANNELS, HIGHEST, LOWEST
from jawenv.errors import InputError, meant, shown
from jawenv.files import InputModel, Number, Text, read_model
from jawenv.playing.maneuvers.signals import SHORTEST_S, AnySignal, KeyframePoint, Keyframes, Signal
from jawenv.playing.protocol import Array

FOLDER = Path(__file__).parent / "shipped"
SUFFIXES = (".yaml", ".yml", ".json", ".toml")
FASTEST_ASKED = 10.0
"""1/s: how fast a target may be asked to move. A device moves one at `FASTEST_TARGET` at most, and lags behind."""
_ROUNDING = 1e-6  # of a bound; what lies beyond by less is within
_AT_REST = Keyframes(kind="keyframes", points=(KeyframePoint(t_s=0.0, value=0.0),))


class Targets(NamedTuple):
    """The channels' targets at one moment, one row per world, columns as in `CHANNELS`."""

    value: Array
    rate: Array


class Channels(InputModel):
    """The target of each channel; a channel left out stays at zero.

    Attributes:
        opening: fraction of the patient's painless range of opening, 0 (rest pose) to 1.
        side: fraction of the soft limit of side motion, -1 to 1, positive to the patient's left.
        fore_aft: fraction of the soft limit of the fore-aft force, -1 to 1, positive forward. The force is
            controlled, not the position, in both control modes.
        roll: fraction of `ROLL_FULL_SCALE_RAD` (four degrees) from the rest pose, -1 to 1, positive lowers the
            right side. Left out, servos hold the roll and force control leaves it free.
    """

    opening: AnySignal
    side: AnySignal = _AT_REST
    fore_aft: AnySignal = _AT_REST
    roll: AnySignal | None = None

    @model_validator(mode="after")
    def _within_limits(self) -> "Channels":
        for name, lowest in zip(CHANNELS, LOWEST, strict=True):
            signal = self.signal(name)
            low, high = signal.bounds()
            if low < lowest - 2.0 * _ROUNDING or high > HIGHEST + 2.0 * _ROUNDING:
                raise ValueError(f"{name} runs from {low:.4g} to {high:.4g}; allowed: {lowest:g} to {HIGHEST:g}")
            fastest = signal.fastest()
            if fastest > FASTEST_ASKED * (1.0 + _ROUNDING):
                raise ValueError(f"{name} moves at {fastest:.4g} per second; allowed: {FASTEST_ASKED:g} at most")
        return self

    def signal(self, name: str) -> Signal:
        """The target of a channel, constant zero where the file names none."""
        return getattr(self, name) or _AT_REST


class Maneuver(InputModel):
    """A named set of targets over time.

    Attributes:
        name: short name, lower case with underscores.
        title: what a table or a figure calls it.
        description: what it does and why.
        source: where the idea comes from.
        fade_in_s: over this time every target grows from rest to its full size.
        channels: the targets.
    """

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]
    title: Annotated[Text, Field(min_length=1)]
    description: Annotated[Text, Field(min_length=1)]
    source: Annotated[Text, Field(min_length=1)]
    fade_in_s: Annotated[Number, Field(ge=SHORTEST_S, le=30)] = 1.0
    channels: Channels

    @model_validator(mode="after")
    def _begins_slowly(self) -> "Maneuver":
        for name in CHANNELS:
            begin = abs(float(self.channels.signal(name).value(0.0)))
            if begin > FASTEST_ASKED * self.fade_in_s + _ROUNDING:
                raise ValueError(
                    f"fade_in_s = {self.fade_in_s:g} takes {name} to {begin:.4g} at {begin / self.fade_in_s:.4g} "
                    f"per second; allowed: {FASTEST_ASKED:g} at most"
                )
        return self

    @cached_property
    def _fade(self) -> Keyframes:
        points = (KeyframePoint(t_s=0.0, value=0.0), KeyframePoint(t_s=self.fade_in_s, value=1.0))
        return Keyframes(kind="keyframes", points=points)

    def targets(self, t: Array) -> Targets:
        """Targets and their rates (1/s) at times t (N,) in seconds: two arrays (N, 4)."""
        fade, fade_rate = self._fade.value(t), self._fade.rate(t)
        signals = [self.channels.signal(name) for name in CHANNELS]
        value = np.stack([signal.value(t) for signal in signals], axis=-1)
        rate = np.stack([signal.rate(t) for signal in signals], axis=-1)
        return Targets(fade[:, None] * value, fade[:, None] * rate + fade_rate[:, None] * value)

    @classmethod
    def named(cls, name: str) -> "Maneuver":
        """One that comes with jawenv, see ``maneuver_names``.

        Raises:
            InputError: no maneuver has this name.
        """
        if name not in maneuver_names():
            names = maneuver_names()
            raise InputError(f"maneuver is {shown(name)}; {meant(name, names)}allowed: {', '.join(names)}")
        return cls.load(FOLDER / f"{name}.yaml")

    @classmethod
    def load(cls, path: str | Path) -> "Maneuver":
        """Read a maneuver file (YAML, JSON or TOML).

        Raises:
            InputError: one line that names the file, the key, the value and what is allowed.
        """
        return read_model(path, cls)


def maneuver_names() -> tuple[str, ...]:
    """The maneuvers that come with jawenv, in alphabetical order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))
