"""The protocol of agents, an action for each observation, and their common parts: form of the answers, memory."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown

Array = NDArray[np.float64]
Observation = NDArray[np.float32]
Action = NDArray[np.float32]
Mask = NDArray[np.bool_]
State = tuple[Any, ...] | None
FIRST_OWN_SEED = 10**9
"""First seed of agents; no world has it (`jawenv.base.seeds`)."""


@runtime_checkable
class Agent(Protocol):
    """A hand-made maneuver, a trained policy or anything else that plays jawenv's environments.

    `predict` has the signature of stable-baselines3's `predict`, so a trained model and a hand-made maneuver are
    interchangeable, also inside `stable_baselines3.common.evaluation.evaluate_policy`.

    An agent whose actions belong to one control mode says so by an attribute ``control``, from which ``jawenv.play``
    takes it.
    """

    name: str  # short name for tables and figures

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget everything and get ready for `num_envs` worlds that start new episodes.

        Args:
            num_envs: how many.
            seed: of the agent's own draws (`own_seed`); it says nothing about the worlds.
        """
        ...

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """Choose the next action.

        Args:
            observation: (N, observation size), or (observation size,) for one world.
            state: what the last call returned. An agent with a memory also keeps it itself, so a caller may leave
                it out.
            episode_start: (N,) true where a new episode begins with this observation.
            deterministic: false lets a stochastic policy draw its action.

        Returns:
            action: (N, 4) or (4,), in [-1, 1].
            state: to be handed to the next call; None for an agent without memory.
        """
        ...


def own_seed(place: int = 0) -> int:
    """A seed for an agent's own draws, made of a place alone.

    Whatever is made of a world's seed, by a digest too, tells that seed to an agent which tries all seeds, and with it
    patient and noise. World i of an agent that seeds its worlds by ``seed + i`` draws as one alone at ``place + i``.

    Args:
        place: of the agent's first world among all that are played.
    """
    return FIRST_OWN_SEED + place


def checked_decision(answer: Any, agent: Any) -> tuple[Any, Any]:
    """The answer of an agent's ``predict``, checked: actions and a state.

    Args:
        answer: what it returned.
        agent: whose name, or class, the message has.
    """
    if not isinstance(answer, tuple | list) or len(answer) != 2 or not hasattr(answer[0], "__len__"):
        name = getattr(agent, "name", type(agent).__name__)
        raise InputError(f"agent '{name}': predict() gives {shown(answer)}; allowed: an array of actions, and a state")
    return answer[0], answer[1]


def introduce(agent: Any, env: Any) -> None:
    """Tell an agent of worlds what it asks for: their configuration, or after their ``reset`` all that a planner needs.

    Args:
        agent: with a method ``take_world(configuration)``, with ``attach(env)``, which a planner has, or with neither.
            It reads the simulation of ``env``, a vector environment after its ``reset``, and changes nothing of it.
        env: an environment of jawenv, of one form or the other.
    """
    configuration = getattr(env.unwrapped, "configuration", None)
    if hasattr(agent, "take_world") and configuration is not None:
        agent.take_world(configuration)
    if hasattr(agent, "attach"):
        agent.attach(env)


class BatchAgent:
    """An agent that answers the observations of N worlds, and a single one as those of one world."""

    name: str  # short name for tables and figures

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """See `Agent.reset`."""

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See `Agent.predict`."""
        rows = np.ascontiguousarray(observation, dtype=np.float32)
        if rows.ndim not in (1, 2):
            raise InputError(f"observation has shape {rows.shape}; allowed: (N, size) and (size,)")
        single, rows = rows.ndim == 1, np.atleast_2d(rows)
        starts = None if episode_start is None else np.asarray(episode_start, dtype=bool).reshape(len(rows))
        action, after = self._answer(rows, state, starts, deterministic)
        return (action[0] if single else action), after

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        """Actions (N, 4) for observations (N, size), of which ``starts`` (N,) begin an episode, and the state after."""
        raise NotImplementedError


class Memory(NamedTuple):
    """An agent's memory."""

    of_worlds: tuple[NDArray[Any], ...]  # arrays (N, ...), one row per world, of zeros where an episode begins
    shared: Any = None  # what it remembers of all worlds together; None where all begin


class Remembering(BatchAgent):
    """An agent with a memory, which it hands out as ``state`` and also keeps: a caller may leave it out."""

    _remembered: tuple[Any, ...]
    """The dtypes of `Memory.of_worlds`."""
    _memory: Memory | None = None

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Forget all worlds; the next observations are taken as the start of their episodes."""
        self._memory = None

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        action, self._memory = self._decide(rows, self._recall(state, len(rows), starts), starts, deterministic)
        return action, self._memory

    def _decide(
        self, rows: Observation, memory: Memory, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, Memory]:
        """Actions (N, 4) for observations (N, size), and the memory after; ``memory`` is a copy."""
        raise NotImplementedError

    def _recall(self, state: State, worlds: int, starts: Mask | None) -> Memory:
        """A copy of the memory to go on from, of zeros for worlds that begin an episode."""
        memory = self._memory if state is None else Memory(*state)
        if memory is None or (starts is not None and starts.all()):
            return Memory(tuple(np.zeros(worlds, dtype) for dtype in self._remembered))
        held = len(memory.of_worlds[0])
        if held != worlds:
            raise InputError(f"observation of {worlds} worlds after {held} worlds: call reset({worlds}) first")
        copies = tuple(array.copy() for array in memory.of_worlds)
        if starts is not None:
            for array in copies:
                array[starts] = np.zeros(1, array.dtype)
        return memory._replace(of_worlds=copies)
