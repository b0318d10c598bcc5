"""Control modes: what the four numbers of an action command."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Literal

from jawenv.errors import InputError, shown

Control = Literal["force", "trajectory", "targets"]
DEFAULT_CONTROL: Final[Control] = "targets"
"""Where nothing is said: in environments, players, agents, commands and studies."""
CONTROL_HZ: dict[str, float] = {"force": 20.0, "trajectory": 20.0, "targets": 5.0}
"""Steps per second where none are given, by control."""


def control_of(agent: Any, env_kwargs: Mapping[str, Any]) -> Any:
    """The control mode in which an agent is played: what is asked for, else its attribute ``control``.

    Args:
        agent: may have the attribute ``control``; None there says nothing.
        env_kwargs: arguments of the environment, of which ``control`` may be one.

    Returns:
        The mode, not checked; None where neither says one, so that the environment has its default.

    Raises:
        InputError: the two contradict each other.
    """
    own = getattr(agent, "control", None)
    asked = env_kwargs.get("control", own)
    if own is not None and asked != own:
        name = getattr(agent, "name", type(agent).__name__)
        raise InputError(f"control is {shown(asked)}; allowed for agent {name!r}, whose actions are of it: {own}")
    return asked
