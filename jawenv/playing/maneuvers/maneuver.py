"""A maneuver, targets over time in a file that a user can write too, and the agent that plays it."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from jawenv.base.errors import InputError, meant, shown
from jawenv.base.files import InputModel, Number, Text, read_model
from jawenv.base.numeric_fields import real_number
from jawenv.controls import CONTROLS, DEFAULT_CONTROL, Control
from jawenv.device.channels import CHANNELS, HIGHEST, LOWEST
from jawenv.device.device import N_MOTORS, Device
from jawenv.device.guard import TRACKER
from jawenv.envs.configuration import Configuration
from jawenv.envs.observation import Parts
from jawenv.envs.world.tracking import follow_all
from jawenv.playing.agents import Action, Array, Mask, Memory, Observation, Remembering
from jawenv.playing.maneuvers.signals import SHORTEST_S, AnySignal, KeyframePoint, Keyframes, Signal

FOLDER = Path(__file__).parent / "shipped"
SUFFIXES = (".yaml", ".yml", ".json", ".toml")
FASTEST_ASKED = 10.0
"""1/s: how fast a target may be asked to move. A device moves one at `FASTEST_TARGET` at most, and lags behind."""
_ROUNDING = 1e-6  # of a bound; what lies beyond by less is within
_LOW = np.array(LOWEST)
_AT_REST = Keyframes(kind="keyframes", points=(KeyframePoint(t_s=0.0, value=0.0),))


class Targets(NamedTuple):
    """The channels' targets at one moment, one row per world, columns as in `CHANNELS`."""

    value: Array
    rate: Array


class Channels(InputModel):
    """The target of each channel; a channel left out stays at zero."""

    opening: AnySignal  # fraction of the patient's painless range of opening, 0 (rest pose) to 1
    side: AnySignal = _AT_REST  # fraction of the soft limit of side motion, -1 to 1, positive to the patient's left
    fore_aft: AnySignal = _AT_REST
    """Fraction of the soft limit of the fore-aft force, -1 to 1, positive forward. The force is controlled, not the
    position, in both control modes.
    """
    roll: AnySignal | None = None
    """Fraction of `ROLL_FULL_SCALE_RAD` (four degrees) from the rest pose, -1 to 1, positive lowers the right side.
    Left out, servos hold the roll and force control leaves it free.
    """

    @model_validator(mode="after")
    def _within_limits(self) -> Channels:
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
    """A named set of targets over time."""

    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]
    """Short name, lower case with underscores."""
    title: Annotated[Text, Field(min_length=1)]
    """Name in tables and figures."""
    description: Annotated[Text, Field(min_length=1)]
    """Its movement, and the reason for it."""
    source: Annotated[Text, Field(min_length=1)]
    """Source of the idea."""
    fade_in_s: Annotated[Number, Field(ge=SHORTEST_S, le=30)] = 1.0
    """Over this time every target grows from rest to its full size."""
    channels: Channels
    """The targets."""

    @model_validator(mode="after")
    def _begins_slowly(self) -> Maneuver:
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
    def named(cls, name: str) -> Maneuver:
        """One that comes with jawenv, see ``maneuver_names``.

        Raises:
            InputError: no maneuver has this name.
        """
        if name not in maneuver_names():
            names = maneuver_names()
            raise InputError(f"maneuver is {shown(name)}; {meant(name, names)}allowed: {', '.join(names)}")
        return cls.load(FOLDER / f"{name}.yaml")

    @classmethod
    def of(cls, source: Maneuver | str | Path) -> Maneuver:
        """One as itself, by its name or as the path of a file."""
        if isinstance(source, Maneuver):
            return source
        return cls.load(source) if Path(source).suffix in SUFFIXES else cls.named(str(source))

    @classmethod
    def load(cls, path: str | Path) -> Maneuver:
        """Read a maneuver file (YAML, JSON or TOML).

        Raises:
            InputError: one line that names the file, the key, the value and what is allowed.
        """
        return read_model(path, cls)


def maneuver_names() -> tuple[str, ...]:
    """The maneuvers that come with jawenv, in alphabetical order."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


class Player(Remembering):
    """A maneuver as an agent, for every control mode.

    In targets control it names the targets, and the device follows them. In the other two it takes the device's law
    (``jawenv.envs.world.tracking``) along. It works from the observation alone and keeps one memory per world.

    Args:
        maneuver: the maneuver, the name of one that comes with jawenv, or the path of a file.
        control: control mode of the environment, which ``jawenv.play`` takes from here.
        control_hz: control steps per second of the environment; None for the mode's default.
        device: of the environment, if not the default one.

    Attributes:
        maneuver: what is played.
        name: the maneuver's.
        control: as given.

    Raises:
        InputError: an unknown maneuver or control mode, or a rate that is not positive.
    """

    # Control steps since the episode began, and records of the device's law.
    _remembered = (np.int64, TRACKER)

    def __init__(
        self,
        maneuver: Maneuver | str | Path,
        *,
        control: Control = DEFAULT_CONTROL,
        control_hz: float | None = None,
        device: Device | None = None,
    ) -> None:
        if control not in CONTROLS:
            raise InputError(f"control is {shown(control)}; allowed: {', '.join(CONTROLS)}")
        hz = real_number(CONTROLS[control].steps_per_s if control_hz is None else control_hz)
        if hz is None or not (np.isfinite(hz) and hz > 0):
            raise InputError(f"control_hz is {shown(control_hz)}; allowed: numbers above 0")
        self.maneuver = Maneuver.of(maneuver)
        self.name = self.maneuver.name
        self.control = control
        self._holds_roll = self.maneuver.channels.roll is not None
        self._device = (device or Device()).records()
        self._dt = 1.0 / hz
        self._parts = Parts()

    def take_world(self, world: Configuration) -> None:
        """Get to know the parts of the observations of the worlds that are to be played; as of ``Jaw-v3`` before."""
        self._parts = world.parts

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        step, trackers = memory.of_worlds
        time = self._dt * step.astype(np.float64)
        if CONTROLS[self.control].takes_targets:
            # Where the jaw is to be at the end of the step.
            action = action_of(self.targets(time + self._dt).value)
        else:
            action = self._follow(rows, trackers, self.targets(time))
        return action.astype(np.float32), Memory((step + 1, trackers))

    def targets(self, time: Array) -> Targets:
        """Targets of N worlds at times (N,) since their episodes began, s."""
        return self.maneuver.targets(time)

    def _follow(self, rows: Observation, trackers: NDArray[np.void], targets: Targets) -> Array:
        check_rows(rows, self._parts)
        trackers["target"], trackers["rate"] = targets.value, targets.rate
        action = np.zeros((len(rows), N_MOTORS))
        servo = CONTROLS[self.control].has_servos
        follow_all(self._device, rows, self._parts.n_parameters, trackers, servo, self._holds_roll, self._dt, action)
        return action


def action_of(targets: Array) -> Array:
    """Actions (N, 4) of targets control for targets (N, 4) as fractions of the patient's comfort."""
    actions: Array = 2.0 * (targets - _LOW) / (HIGHEST - _LOW) - 1.0
    return np.clip(actions, -1.0, 1.0)


def goals_of(actions: NDArray[Any]) -> Array:
    """Targets (..., 4) that actions (..., 4) of targets control ask for, as fractions of the patient's comfort."""
    goals: Array = _LOW + 0.5 * (HIGHEST - _LOW) * (np.asarray(actions, dtype=np.float64) + 1.0)
    return goals


def check_rows(rows: Observation, parts: Parts) -> None:
    """Make sure that observations (N, size) are finite, and of these parts."""
    parts.check(rows.shape[1], "a maneuver")
    if not np.isfinite(rows).all():
        raise InputError("observation holds a value that is not finite")
