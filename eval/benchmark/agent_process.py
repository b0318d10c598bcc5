"""Agents with code to run on loading, in a process of their own: observations in, actions out, as lines of JSON.

Neither process unpickles what the other writes, and the agent's has no object of an environment. It has the rights of
whoever starts it: files and other processes are not kept from it.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import weakref
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from agents import registry
from jawenv.controls import CONTROLS
from jawenv.errors import InputError, shown
from jawenv.named_objects import is_named
from jawenv.playing.agents import Action, Agent, Mask, Observation, State, checked_decision

_LONGEST_LINE = 2**24  # bytes
_LONGEST_TEXT = 200
_ACTION_SIZE = 4


def load_apart(spec: str | Path, *, trust: bool = False, **settings: Any) -> Agent:
    """As `agents.registry.load_agent`; a module or a pickled checkpoint in a process of its own.

    Raises:
        InputError: as `load_agent`.
    """
    if is_named(str(spec)) or (trust and Path(spec).suffix == ".zip"):
        return AgentProcess(str(spec), trust=trust, **settings)
    return registry.load_agent(spec, trust=trust, **settings)


class AgentProcess:
    """An agent in another process, which ends with this object.

    Args:
        spec: see `agents.registry.load_agent`.
        **settings: of `load_agent`, values that JSON can hold.

    Attributes:
        name: of the agent.
        description: its own, or empty.
        control: its control mode, where it says so.
        made_of: files that decide its actions, beside its module.

    Raises:
        InputError: `load_agent` refuses it, or its process ends or answers something else than was asked for.
    """

    def __init__(self, spec: str, **settings: Any) -> None:
        self._spec = spec
        paths = os.pathsep.join(path or os.getcwd() for path in sys.path)
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": paths},
        )
        weakref.finalize(self, _end, self._process)
        answer = self._ask({"spec": spec, "settings": settings})
        self.name, self.description = self._text(answer, "name"), self._text(answer, "description")
        self.made_of = answer.get("made_of", [])
        if answer.get("control") in CONTROLS:
            self.control = answer["control"]

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """See `Agent.reset`."""
        self._ask({"reset": [num_envs, seed]})

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See `Agent.predict`; a state stays in the other process."""
        starts = None if episode_start is None else np.asarray(episode_start).tolist()
        answer = self._ask({"observation": np.asarray(observation).tolist(), "starts": starts, "same": deterministic})
        try:
            action = np.array(answer.get("action"), dtype=np.float32)
        except (TypeError, ValueError):
            action = np.empty(0, dtype=np.float32)
        expected = (*np.shape(observation)[:-1], _ACTION_SIZE)
        if action.shape != expected:
            raise InputError(f"agent '{self._spec}': actions of shape {action.shape}; allowed: {expected}")
        return action, None

    def _ask(self, question: dict[str, Any]) -> dict[str, Any]:
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            _write(self._process.stdin, question)
            answer = _read(self._process.stdout)
        except (OSError, ValueError):
            answer = None
        if answer is None:
            raise InputError(f"agent '{self._spec}': its process has ended, or answers something else than JSON")
        if "error" in answer:
            raise InputError(" ".join(str(answer["error"]).split())[: 2 * _LONGEST_TEXT])
        return answer

    def _text(self, answer: dict[str, Any], name: str) -> str:
        text = answer.get(name)
        if not isinstance(text, str) or not text.isprintable() or len(text) > _LONGEST_TEXT:
            raise InputError(f"agent '{self._spec}': its {name} is {shown(text)}; allowed: one line of text")
        return text


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.communicate()


def _write(stream: BinaryIO | Any, content: dict[str, Any]) -> None:
    stream.write(json.dumps(content).encode() + b"\n")
    stream.flush()


def _read(stream: BinaryIO | Any) -> dict[str, Any] | None:
    """The next line; None at the end.

    Raises:
        ValueError: it is no object of JSON.
    """
    line = stream.readline(_LONGEST_LINE)
    content = json.loads(line) if line else None
    if content is not None and not isinstance(content, dict):
        raise ValueError
    return content


class _Answers:
    """The other process's part: questions to answers."""

    def __init__(self) -> None:
        self._agent: Any = None
        self._state: State = None

    def to(self, question: dict[str, Any]) -> dict[str, Any]:
        if "spec" in question:
            self._agent = registry.load_agent(question["spec"], **question["settings"])
            return _about(self._agent)
        if "reset" in question:
            self._state = None
            self._agent.reset(*question["reset"])
            return {}
        observation = np.array(question["observation"], dtype=np.float32)
        starts = None if question["starts"] is None else np.array(question["starts"], dtype=bool)
        answer = self._agent.predict(observation, self._state, starts, question["same"])
        action, self._state = checked_decision(answer, self._agent)
        return {"action": np.asarray(action).tolist()}


def _about(agent: Any) -> dict[str, Any]:
    """Name, description, control mode and files of an agent."""
    if hasattr(agent, "attach"):
        raise InputError(f"agent '{agent.name}': has attach(); allowed: agents that know observations alone")
    maneuver = getattr(agent, "maneuver", None)
    description = " ".join(str(getattr(maneuver or agent, "description", "")).split())[:_LONGEST_TEXT]
    files = [str(path) for path in getattr(agent, "made_of", ())]
    return {"name": agent.name, "description": description, "control": getattr(agent, "control", ""), "made_of": files}


def _serve() -> None:
    """Answer the questions of the standard input until it ends; prints of the agent go to the standard error."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends with the other process
    answers, stream = _Answers(), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    while (question := _read(sys.stdin.buffer)) is not None:
        try:
            answer = answers.to(question)
        except Exception as error:  # code of the user's can raise anything
            answer = {"error": str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"}
        _write(stream, answer)


if __name__ == "__main__":
    _serve()
