"""Plays a maneuver: at each step the targets of its file become an action, within the patient's comfort."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.checks import real_number
from jawenv.controls import CONTROLS, DEFAULT_CONTROL, Control
from jawenv.device.channels import HIGHEST, LOWEST, TRACKER
from jawenv.device.device import N_MOTORS, Device
from jawenv.envs.observation import parameters_of
from jawenv.envs.world.tracking import follow_all
from jawenv.errors import InputError, shown
from jawenv.playing.agents import Memory, Remembering
from jawenv.playing.maneuvers.maneuver import SUFFIXES, Maneuver, Targets
from jawenv.playing.protocol import Action, Array, Mask, Observation

_LOW = np.array(LOWEST)


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
        self.maneuver = _maneuver(maneuver)
        self.name = self.maneuver.name
        self.control = control
        self._holds_roll = self.maneuver.channels.roll is not None
        self._device = (device or Device()).records()
        self._dt = 1.0 / hz

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        parameters = checked_parameters(rows)
        step, trackers = memory.of_worlds
        time = self._dt * step.astype(np.float64)
        if CONTROLS[self.control].takes_targets:
            # Where the jaw is to be at the end of the step.
            action = action_of(self.targets(time + self._dt).value)
        else:
            action = self._follow(rows, parameters, trackers, self.targets(time))
        return action.astype(np.float32), Memory((step + 1, trackers))

    def targets(self, time: Array) -> Targets:
        """Targets of N worlds at times (N,) since their episodes began, s."""
        return self.maneuver.targets(time)

    def _follow(self, rows: Observation, parameters: int, trackers: NDArray[np.void], targets: Targets) -> Array:
        trackers["target"], trackers["rate"] = targets.value, targets.rate
        action = np.zeros((len(rows), N_MOTORS))
        servo = CONTROLS[self.control].has_servos
        follow_all(self._device, rows, parameters, trackers, servo, self._holds_roll, self._dt, action)
        return action


def action_of(targets: Array) -> Array:
    """Actions (N, 4) of targets control for targets (N, 4) as fractions of the patient's comfort."""
    actions: Array = 2.0 * (targets - _LOW) / (HIGHEST - _LOW) - 1.0
    return np.clip(actions, -1.0, 1.0)


def goals_of(actions: NDArray[Any]) -> Array:
    """Targets (..., 4) that actions (..., 4) of targets control ask for, as fractions of the patient's comfort."""
    goals: Array = _LOW + 0.5 * (HIGHEST - _LOW) * (np.asarray(actions, dtype=np.float64) + 1.0)
    return goals


def checked_parameters(rows: Observation) -> int:
    """The number of parameters that observations (N, size) are of.

    Raises:
        InputError: an observation of another size, or one that is not finite.
    """
    parameters = parameters_of(rows.shape[1])
    if not np.isfinite(rows).all():
        raise InputError("observation holds a value that is not finite")
    return parameters


def _maneuver(source: Maneuver | str | Path) -> Maneuver:
    if isinstance(source, Maneuver):
        return source
    return Maneuver.load(source) if Path(source).suffix in SUFFIXES else Maneuver.named(str(source))
