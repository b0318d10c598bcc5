"""The mean actions of an agent over patients, as a maneuver: the control for whether it adapts.

An agent that adapts to the patient does better than its own averaged targets, replayed without looking. An average
smooths out what an agent does with each patient at another moment, so there is a harder control: what it did with
another patient (yoked replay).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from safetensors.numpy import save

from jawenv.base.errors import InputError, printable, shown
from jawenv.base.files import atomic_write
from jawenv.base.reading import read_bytes
from jawenv.controls import DEFAULT_CONTROL, Control, control_of, takes_targets
from jawenv.device.channels import CHANNELS, FASTEST_TARGET
from jawenv.playing.agents import Action, Agent, Array, BatchAgent, Mask, Observation, State
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.maneuver import goals_of
from jawenv.playing.maneuvers.written import maneuver_of_targets
from jawenv.playing.policies.controller import ControlledAgent
from jawenv.playing.policies.following import TargetsLaw
from jawenv.playing.policies.plain import arrays_in
from jawenv.playing.rollout import DEFAULT_ENV, play

LARGEST = 256 * 2**20
"""Bytes: the actions of a thousand patients over ten minutes take 200 MB."""


class Replay(BatchAgent):
    """Actions of targets control that were recorded on other patients: world i gets those of patient i there.

    Args:
        name: label in tables.
        actions: (N, T, 4) in [-1, 1]; more worlds begin again at the first patient, and after T actions the last one
            holds.
        decision_hz: actions per second.

    Attributes:
        name: as given.
        control: "targets".
        decision_hz: as given.
        number: of sequences.
    """

    control: Control = "targets"

    def __init__(self, name: str, actions: Array, decision_hz: float) -> None:
        self.name, self.decision_hz = name, decision_hz
        self._actions, self._step = actions, 0
        self.number = len(actions)

    @classmethod
    def load(cls, path: Path) -> Replay:
        """Read a file of ``save``."""
        held = arrays_in(path, read_bytes(path, LARGEST))
        if set(held) != {"actions", "decision_hz"}:
            raise InputError(f"{path}: holds {shown(sorted(held))}; allowed: actions and decision_hz")
        actions, hz = held["actions"], held["decision_hz"]
        right = actions.ndim == 3 and actions.shape[2] == len(CHANNELS) and actions.size and actions.dtype.kind == "f"
        if not right or not (np.abs(actions) <= 1.0).all():
            raise InputError(f"{path}: actions have shape {actions.shape}; allowed: (N, T, 4), each in [-1, 1]")
        if hz.shape != () or hz.dtype.kind not in "iuf" or not 0.0 < hz < np.inf:
            raise InputError(f"{path}: decision_hz is {shown(hz.tolist())}; allowed: a positive number")
        return cls(printable(path.stem), actions.astype(np.float64), float(hz))

    def save(self, path: Path) -> None:
        """Write actions and rate (.safetensors), wholly or not at all; the file's name is the label."""
        content = save({"actions": np.ascontiguousarray(self._actions), "decision_hz": np.array(self.decision_hz)})
        with atomic_write(path) as unfinished:
            unfinished.write_bytes(content)

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Begin again."""
        self._step = 0

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        if starts is not None and starts.all():  # all worlds begin at once
            self._step = 0
        worlds = np.arange(len(rows)) % len(self._actions)
        action = self._actions[worlds, min(self._step, self._actions.shape[1] - 1)]
        self._step += 1
        return action.astype(np.float32), None


def check_targets(agent: Agent, env_kwargs: dict[str, Any]) -> None:
    """Make sure that an agent says where the jaw shall be, so that this can be replayed."""
    control = control_of(agent, env_kwargs) or DEFAULT_CONTROL
    if not takes_targets(control) and not _followed(agent):
        raise InputError(
            f"replay of {agent.name!r}: control is {shown(control)}; allowed: targets, or a policy of targets"
        )


def _followed(agent: Agent) -> bool:
    """Whether the device's law follows an agent's targets in another control mode."""
    return isinstance(agent, ControlledAgent) and isinstance(agent.controller, TargetsLaw)


def replays_of(
    agent: Agent,
    *,
    patients: int,
    seed: int,
    env_kwargs: dict[str, Any],
    env_id: str = DEFAULT_ENV,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Maneuver, Replay]:
    """The maneuver of an agent's targets, averaged over patients, and the actions with each.

    Args:
        agent: plays targets control, or has its targets followed (`jawenv.playing.policies.following`).
        patients: how many, by the seeds from `seed` on; not those that agent and replay are compared on.
        seed: of the first patient.
        env_kwargs: arguments of the environment.
        env_id: its id.
        progress: see ``jawenv.play``.
    """
    check_targets(agent, env_kwargs)
    followed_agent = agent if isinstance(agent, ControlledAgent) and _followed(agent) else None
    every = 1 if followed_agent is None else followed_agent.controller.steps_per_decision
    decided: list[Action] = []  # in every control step

    def note(env: Any, action: Action | None) -> None:
        if action is not None:
            decision = action if followed_agent is None else followed_agent.decision
            assert decision is not None
            decided.append(decision)

    recording = play(
        agent,
        patients=patients,
        seed=seed,
        env_kwargs={"track_bound": False, **env_kwargs},
        env_id=env_id,
        progress=progress,
        on_step=note,
    )
    period = every * float(recording.time[1])
    actions = np.stack(decided[::every], axis=1).astype(np.float64)
    targets = targets_of(actions, period)
    running = recording.valid[:, :-1:every, None]  # at the beginning of the step
    mean = np.sum(targets * running, axis=0) / np.maximum(running.sum(axis=0), 1)
    name = re.sub(r"[^a-z0-9]+", "_", agent.name.lower()).strip("_")
    header = {
        "name": f"replay_of_{name}",
        "title": f"Replay of {agent.name}",
        "description": f"The targets of {agent.name}, averaged over {patients} patients, replayed without looking.",
        "source": f"python -m eval replay, seeds {seed} to {seed + patients - 1} of cohort "
        f"{env_kwargs.get('cohort', 'trismus')}",
    }
    return maneuver_of_targets(mean, period, header), Replay(f"yoked_replay_of_{name}", actions, 1.0 / period)


def targets_of(actions: Array, period: float) -> Array:
    """Targets at the end of each step, moved as fast as the device lets them.

    Args:
        actions: (N, T, 4) of targets control, in [-1, 1].
        period: length of a step, s.

    Returns:
        (N, T, 4) fractions of the patient's comfort.
    """
    goals = goals_of(actions)
    fastest = np.array(FASTEST_TARGET) * period
    targets, last = np.empty_like(goals), np.zeros_like(goals[:, 0])
    for step in range(goals.shape[1]):
        last = last + np.clip(goals[:, step] - last, -fastest, fastest)
        targets[:, step] = last
    return targets
