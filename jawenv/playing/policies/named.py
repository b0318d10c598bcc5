"""Agents that come with jawenv, by name."""

from __future__ import annotations

from pathlib import Path

from jawenv.base.errors import InputError, not_among
from jawenv.controls import CONTROLS, Control, control_of
from jawenv.ladder import DEFAULT_ENV
from jawenv.playing.agents import Agent
from jawenv.playing.excitation import BASELINES
from jawenv.playing.maneuvers import Player, maneuver_names
from jawenv.playing.maneuvers.maneuver import SUFFIXES
from jawenv.playing.policies.card import policy_folder, policy_names


def agent_names() -> tuple[str, ...]:
    """Maneuvers, policies and baselines that come with jawenv."""
    return (*maneuver_names(), *policy_names(), *BASELINES)


def named_agent(
    spec: str | Path, control: Control, control_hz: float | None = None, env_id: str = DEFAULT_ENV
) -> Agent | None:
    """The agent of a name, a maneuver file or a policy's folder; None if the text stands for none of these.

    Args:
        spec: one of `agent_names()`, the path of a maneuver file, or the folder of a policy.
        control: control mode of the environment that the agent shall play.
        control_hz: control steps per second of that environment; None for its default.
        env_id: that environment, by its id or as `jawenv.ladder.model_of_env` takes it.
    """
    if str(spec) in BASELINES:
        return BASELINES[str(spec)](steps_per_s(control, control_hz))
    folder = policy_folder(spec)
    if str(spec) in maneuver_names() or (folder is None and Path(spec).suffix in SUFFIXES):
        return Player(spec, control=control, control_hz=control_hz)
    if folder is None:
        return None
    from jawenv.playing.policies.plain import load_plain

    return in_control(load_plain(folder, env_id), control, control_hz)


def agent_of(spec: str | Path, control: Control, control_hz: float | None, env_id: str) -> Agent:
    """Load the agent of `named_agent`, or refuse a text that stands for none."""
    agent = named_agent(spec, control, control_hz, env_id)
    if agent is None:
        files = f", a maneuver file ({', '.join(SUFFIXES)}) or a policy's folder"
        raise not_among("agent", str(spec), agent_names(), files)
    return agent


def in_control(policy: Agent, control: Control, control_hz: float | None) -> Agent:
    """A policy as an agent of the control mode; where it says targets at a rate of its own, they are followed."""
    decision_hz: float | None = getattr(policy, "decision_hz", None)
    if decision_hz is None:
        control_of(policy, {"control": control})
        return policy
    hz = steps_per_s(control, control_hz)
    if not CONTROLS[control].takes_targets:
        from jawenv.playing.policies.controller import ControlledAgent
        from jawenv.playing.policies.following import TargetsLaw

        return ControlledAgent(policy, TargetsLaw(control, hz, decision_hz))
    if abs(hz - decision_hz) > 1e-6 * hz:
        raise InputError(f"control_hz {hz:g}: {policy.name} decides {decision_hz:g} times a second")
    return policy


def steps_per_s(control: Control, control_hz: float | None) -> float:
    """Control steps per second, the control's own where none are given."""
    return CONTROLS[control].steps_per_s if control_hz is None else control_hz
