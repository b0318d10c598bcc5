"""Control modes: what the four numbers of an action command."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

from jawenv.base.errors import InputError, not_among, shown

Control = Literal["force", "trajectory", "targets"]
DEFAULT_CONTROL: Final[Control] = "targets"
"""Default of environments, players, agents, commands and studies."""


@dataclass(frozen=True)
class ControlMode:
    """A control mode, as all other parts need it."""

    name: Control  # as arguments have it
    steps_per_s: float  # where none are given
    has_servos: bool  # whether position servos hold the motors
    takes_targets: bool  # whether the numbers are targets of the channels, which the device's own law follows
    commanded: tuple[str, str, str, str]  # names of the four numbers
    full_action: str  # what a number of 1 commands


_MOTORS = ("motor 1", "motor 2", "motor 3", "motor 4")
_CHANNELS = ("opening", "side", "fore-aft", "roll")
CONTROLS: dict[str, ControlMode] = {
    mode.name: mode
    for mode in (
        ControlMode("force", 20.0, False, False, _MOTORS, "`full_scale_N` of that motor at the mouthpiece"),
        ControlMode("trajectory", 20.0, True, False, _MOTORS, "`max_rate_mm_s` of that motor's target position"),
        ControlMode("targets", 5.0, True, True, _CHANNELS, "where the jaw is to be at the end of the step"),
    )
}
"""The control modes, by name."""


def takes_targets(control: object) -> bool:
    """Whether actions of a control mode are targets; not where it is no mode, which the environment refuses."""
    return isinstance(control, str) and control in CONTROLS and CONTROLS[control].takes_targets


def mode_of(env_kwargs: Mapping[str, Any]) -> ControlMode:
    """The control mode of an environment with such arguments."""
    control = env_kwargs.get("control", DEFAULT_CONTROL)
    if not isinstance(control, str) or control not in CONTROLS:
        raise not_among("control", control, CONTROLS)
    return CONTROLS[control]


def control_of(agent: Any, env_kwargs: Mapping[str, Any]) -> Any:
    """The control mode in which an agent is played: what is asked for, else its attribute ``control``.

    Args:
        agent: may have the attribute ``control``; None there says nothing.
        env_kwargs: arguments of the environment, of which ``control`` may be one.

    Returns:
        The mode's name, not checked; None where neither says one, so that the environment has its default.
    """
    own = getattr(agent, "control", None)
    asked = env_kwargs.get("control", own)
    if own is not None and asked != own:
        name = getattr(agent, "name", type(agent).__name__)
        raise InputError(f"control is {shown(asked)}; allowed for agent {name!r}, whose actions are of it: {own}")
    return asked
