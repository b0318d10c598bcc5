"""Common parts of agents: the form of their answers, a memory of each world, and listening to another agent."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError
from jawenv.playing.protocol import Action, Mask, Observation, State

__all__ = ["BatchAgent", "Memory", "Remembering", "check_size"]


class BatchAgent:
    """An agent that answers the observations of N worlds, and a single one as those of one world.

    Attributes:
        name: short name for tables and figures.
    """

    name: str

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """See `jawenv.playing.protocol.Agent.reset`."""

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See `jawenv.playing.protocol.Agent.predict`.

        Raises:
            InputError: an observation of the wrong shape, or what the agent refuses.
        """
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
    """An agent's memory.

    Attributes:
        of_worlds: arrays (N, ...), one row per world, of zeros where an episode begins.
        shared: what it remembers of all worlds together; None where all begin.
    """

    of_worlds: tuple[NDArray[Any], ...]
    shared: Any = None


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
        """A copy of the memory to go on from, of zeros for worlds that begin an episode.

        Raises:
            InputError: another number of worlds than before.
        """
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


def check_size(rows: Observation, size: int, policy: object) -> None:
    """Make sure that observations (N, size) are of the size that a policy was trained on.

    Raises:
        InputError: they are not.
    """
    if rows.shape[1] != size:
        raise InputError(f"{policy}: the policy was trained on observations of {size} values, got {rows.shape[1]}")
