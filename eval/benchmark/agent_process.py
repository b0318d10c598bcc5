"""Agents with code to run on loading, in a process of their own: observations in, actions out, as lines of JSON.

Neither process unpickles what the other writes, and the agent's has no object of an environment. It has the rights of
whoever starts it: files and other processes are not kept from it. Questions and answers have descriptors of their own:
0 to 2 are the agent's, with nothing to read. An answer that is late, or no answer, ends the process.
"""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import signal
import subprocess
import sys
import time
import weakref
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from agents import registry
from jawenv.anatomy.prior import Prior
from jawenv.base.errors import InputError, shown
from jawenv.base.named_objects import is_named
from jawenv.controls import CONTROLS
from jawenv.playing.agents import Action, Agent, Mask, Observation, State, checked_decision

DECISION_S = 20.0
"""Longest time that an agent may take for one decision, of up to 50 worlds: twice the device's 0.2 s for each."""
LOADING_S = 60.0
"""Longest time until it is loaded."""
_LONGEST_LINE = 2**24  # bytes
_PIECE = 2**16  # bytes
_MOST_FILES = 1000
_LONGEST_TEXT = 200
_ACTION_SIZE = 4


def load_apart(spec: str | Path, *, trust: bool = False, **settings: Any) -> Agent:
    """Load an agent as `agents.registry.load_agent` does; a module or a pickled checkpoint in its own process."""
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
    """

    def __init__(self, spec: str, **settings: Any) -> None:
        self._spec = spec
        theirs, self._questions = os.pipe()
        self._answers, answers = os.pipe()
        try:
            paths = os.pathsep.join(path or os.getcwd() for path in sys.path)
            process = subprocess.Popen(
                [sys.executable, "-m", __name__, str(theirs), str(answers)],
                stdin=subprocess.DEVNULL,
                stdout=2,
                pass_fds=(theirs, answers),
                start_new_session=True,  # with the programs that it starts, it can be ended as a whole
                env={**os.environ, "PYTHONPATH": paths},
            )
        finally:
            os.close(theirs)
            os.close(answers)
        self._end = weakref.finalize(self, _end, process, self._questions, self._answers)
        os.set_blocking(self._questions, False)
        os.set_blocking(self._answers, False)
        answer = self._ask({"spec": spec, "settings": settings}, LOADING_S)
        self.name, self.description = self._text(answer, "name"), self._text(answer, "description")
        self.made_of = answer.get("made_of", [])
        if not isinstance(self.made_of, list) or len(self.made_of) > _MOST_FILES:
            raise InputError(f"agent '{spec}': made_of is {shown(self.made_of)}; allowed: {_MOST_FILES} paths at most")
        if answer.get("control") in tuple(CONTROLS):
            self.control = answer["control"]

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """See `Agent.reset`."""
        self._ask({"reset": [num_envs, seed]})

    def take_prior(self, prior: Prior) -> None:
        """Tell the agent the prior, which an entrant may know."""
        self._ask({"prior": [prior.mean.tolist(), prior.sd.tolist()]})

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
        action = _numbers(answer.get("action"))
        expected = (*np.shape(observation)[:-1], _ACTION_SIZE)
        if action.shape != expected:
            raise InputError(f"agent '{self._spec}': actions of shape {action.shape}; allowed: {expected}")
        if not np.isfinite(action).all():
            raise InputError(f"agent '{self._spec}': actions hold a value that is not finite")
        return action, None

    def _ask(self, question: dict[str, Any], limit_s: float | None = None) -> dict[str, Any]:
        limit_s = DECISION_S if limit_s is None else limit_s
        try:
            if not self._end.alive:
                raise EOFError
            answer = _content(self._exchanged(_line(question), time.monotonic() + limit_s))
        except TimeoutError:
            self._end()
            raise InputError(f"agent '{self._spec}': no answer within {limit_s:g} s") from None
        except (OSError, EOFError, ValueError, RecursionError):
            self._end()
            raise InputError(
                f"agent '{self._spec}': its process has ended, or answers something else than JSON"
            ) from None
        except BaseException:  # an interrupt: the answer would be taken for the next question's
            self._end()
            raise
        if "error" in answer:
            error = answer["error"] if isinstance(answer["error"], str) else "an error that is no text"
            raise InputError(" ".join(error[:_LONGEST_LINE].split())[: 2 * _LONGEST_TEXT])
        return answer

    def _exchanged(self, question: bytes, until: float) -> bytes:
        """Send a line, and receive one.

        Raises:
            TimeoutError: not before `until`, in `time.monotonic`.
            EOFError: the other end is closed.
            ValueError: the line is too long, or followed by more than was asked for.
        """
        unsent, answer = memoryview(question), bytearray()
        with selectors.DefaultSelector() as ready:
            ready.register(self._answers, selectors.EVENT_READ)
            ready.register(self._questions, selectors.EVENT_WRITE)
            while b"\n" not in answer[-_PIECE:]:
                if (left := until - time.monotonic()) <= 0.0:
                    raise TimeoutError
                for key, _ in ready.select(left):
                    if key.fd == self._questions:
                        unsent = unsent[os.write(self._questions, unsent[:_PIECE]) :]
                        if not unsent:
                            ready.unregister(self._questions)
                    elif piece := os.read(self._answers, _PIECE):
                        answer += piece
                    else:
                        raise EOFError
                if len(answer) > _LONGEST_LINE:
                    raise ValueError
        if unsent or answer.index(b"\n") < len(answer) - 1:
            raise ValueError
        return bytes(answer)

    def _text(self, answer: dict[str, Any], name: str) -> str:
        text = answer.get(name)
        if not isinstance(text, str) or not text.isprintable() or len(text) > _LONGEST_TEXT:
            raise InputError(f"agent '{self._spec}': its {name} is {shown(text)}; allowed: one line of text")
        return text


def _end(process: subprocess.Popen[bytes], *descriptors: int) -> None:
    """End a process and all that it started; nothing is waited for that another process could hold open."""
    for descriptor in descriptors:
        os.close(descriptor)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _numbers(answer: Any) -> Action:
    """Actions of an answer; of shape (0,) where it holds anything but numbers."""
    try:
        values = np.array(answer)
        with np.errstate(over="ignore"):
            return values.astype(np.float32) if values.dtype.kind in "iuf" else np.empty(0, dtype=np.float32)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0, dtype=np.float32)


def _line(content: dict[str, Any]) -> bytes:
    return json.dumps(content).encode() + b"\n"


def _content(line: bytes) -> dict[str, Any]:
    """The content of a line of JSON.

    Raises:
        ValueError: it is no object of JSON.
    """
    content = json.loads(line)
    if not isinstance(content, dict):
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
        if "prior" in question:
            if hasattr(self._agent, "take_prior"):
                self._agent.take_prior(Prior(*map(np.array, question["prior"])))
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


def _serve(questions: BinaryIO, answers: BinaryIO) -> None:
    """Answer questions until they end."""
    part = _Answers()
    for question in questions:
        try:
            answer = _line(part.to(_content(question)))
        except Exception as error:  # code of the user's can raise anything
            said = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
            answer = _line({"error": said})
        answers.write(answer)
        answers.flush()


if __name__ == "__main__":
    own = [int(descriptor) for descriptor in sys.argv[1:3]]
    for descriptor in own:
        os.set_inheritable(descriptor, False)  # programs that the agent starts have no part in this
    _serve(os.fdopen(own[0], "rb"), os.fdopen(own[1], "wb"))
