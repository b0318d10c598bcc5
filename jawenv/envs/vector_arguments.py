"""The arguments that only the vector form has, checked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from gymnasium.vector import AutoresetMode

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import whole_number
from jawenv.envs.episode_seeds import checked_seed

__all__ = ["checked_autoreset_mode", "checked_num_envs", "checked_seeds", "checked_steps", "enough_memory"]


def checked_num_envs(value: object) -> int:
    """Checked number of worlds."""
    number = whole_number(value)
    if number is None or number < 1:
        raise InputError(f"num_envs is {shown(value)}; allowed: a whole number, 1 or more")
    return number


@contextmanager
def enough_memory(num_envs: int) -> Iterator[None]:
    """Around the allocation of the worlds."""
    try:
        yield
    except InputError:
        raise
    except (MemoryError, ValueError, OverflowError):
        raise InputError(f"num_envs is {shown(num_envs)}; allowed: as many as fit the memory") from None


def checked_autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """Gymnasium's mode, or the one of a name."""
    if isinstance(mode, AutoresetMode):
        return mode
    names = [member.name.lower() for member in AutoresetMode]
    if str(mode).lower() not in names:
        raise InputError(f"autoreset_mode is {shown(mode)}; allowed: {', '.join(names)}")
    return AutoresetMode[str(mode).upper()]


def checked_steps(value: object) -> float:
    """The most steps of an episode; infinite for None, and for -1 as ``gymnasium.make`` takes it."""
    if value is None:
        return math.inf
    steps = whole_number(value)
    if steps is None or (steps < 1 and steps != -1):
        raise InputError(f"max_episode_steps is {shown(value)}; allowed: a whole number, 1 or more, or None")
    return math.inf if steps == -1 else steps


def checked_seeds(value: object, number: int) -> list[int | None]:
    """Seeds of N worlds: s + i of a whole number s, or the entries of a sequence."""
    if isinstance(value, Sequence | np.ndarray):
        seeds = [checked_seed(entry) for entry in value]
        if len(seeds) != number:
            raise InputError(f"seed has {len(seeds)} entries; allowed: an integer or {number} entries")
        return seeds
    first = checked_seed(value)
    return [None if first is None else first + i for i in range(number)]
