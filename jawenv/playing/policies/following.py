"""Agents of targets control in force and trajectory control: the device's law follows their targets.

In targets control the device itself does that. Here an agent decides as often as there, and between two decisions the
law (`jawenv.envs.world.tracking`) turns the targets into the action of each control step, as it does for maneuvers.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import real_number
from jawenv.controls import CONTROLS, DEFAULT_CONTROL, Control, takes_targets
from jawenv.device.channels import FASTEST_TARGET
from jawenv.device.device import N_MOTORS, Device
from jawenv.device.guard import TRACKER
from jawenv.envs.configuration import Configuration
from jawenv.envs.observation import Parts
from jawenv.envs.world.tracking import follow_all
from jawenv.playing.agents import Action, Observation
from jawenv.playing.maneuvers.maneuver import check_rows, goals_of

DECISION_HZ = CONTROLS["targets"].steps_per_s
Trackers = NDArray[np.void]


def decision_hz(env_kwargs: Mapping[str, Any]) -> float:
    """Decisions per second of a policy of targets that was trained with such arguments of the environment."""
    asked = env_kwargs.get("control_hz") if takes_targets(env_kwargs.get("control", DEFAULT_CONTROL)) else None
    hz = real_number(DECISION_HZ if asked is None else asked)
    if hz is None or not (np.isfinite(hz) and hz > 0):
        raise InputError(f"control_hz is {shown(asked)}; allowed: a positive number")
    return hz


class TargetsLaw:
    """Targets become actions of force or trajectory control: the controller of agents of targets control there.

    Its memory is the device's tracker. A world that begins an episode between two decisions keeps still until the next.

    Args:
        control: "force" or "trajectory".
        control_hz: control steps per second of the environment; None for the mode's default.
        decision_hz: decisions per second.

    Attributes:
        control: as given.
        decision_hz: as given.
        steps_per_decision: control steps from one decision to the next.
    """

    n_features = 0
    memory: np.dtype[Any] = TRACKER

    def __init__(self, control: Control, control_hz: float | None = None, decision_hz: float = DECISION_HZ) -> None:
        mode = CONTROLS[control]
        hz = mode.steps_per_s if control_hz is None else control_hz
        self.control = control
        self.decision_hz = decision_hz
        self.steps_per_decision = round(hz / decision_hz)
        if abs(self.steps_per_decision * decision_hz - hz) > 1e-9 * hz:
            raise InputError(f"control_hz is {hz:g}; allowed: a multiple of the {decision_hz:g} decisions per second")
        self._servo = mode.has_servos
        self._device = Device().records()
        self._dt, self._decision_s = 1.0 / hz, 1.0 / decision_hz
        self._parts = Parts()

    def take_world(self, world: Configuration) -> None:
        """Get to know the parts of the observations of the worlds that are to be played; as of ``Jaw-v3`` before."""
        self._parts = world.parts

    def seen(self, rows: Observation, memory: Trackers) -> Observation:
        """Observations (N, size) with ``motor_target`` as in targets control."""
        check_rows(rows, self._parts)
        rows = rows.copy()
        target = memory["target"] * np.where(memory["begun"][:, None], memory["size"], 1.0)
        rows[:, self._parts.layout["motor_target"]] = target
        return rows

    def act(self, rows: Observation, memory: Trackers, decision: Action | None) -> Action:
        """Actions (N, 4) of this control step; the targets move on.

        Args:
            rows: (N, size) observations.
            memory: (N,) records of the law.
            decision: (N, 4) actions of targets control, with the targets at the next decision.
        """
        check_rows(rows, self._parts)
        if decision is not None:
            rate = (goals_of(np.clip(decision, -1.0, 1.0)) - memory["target"]) / self._decision_s
            memory["rate"] = np.clip(rate, -_FASTEST, _FASTEST)
        action = np.zeros((len(rows), N_MOTORS))
        follow_all(self._device, rows, self._parts.n_parameters, memory, self._servo, True, self._dt, action)
        memory["target"] += self._dt * memory["rate"]
        return action.astype(np.float32)


_FASTEST = np.array(FASTEST_TARGET)
