"""Seeds of ``reset``, checked, and the first random numbers of an episode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import whole_number


def checked_seed(value: object) -> int | None:
    """A seed as an int, or None."""
    if value is None:
        return None
    seed = whole_number(value)
    if seed is None or seed < 0:
        raise InputError(f"seed is {shown(value)}; allowed: a whole number, 0 or more")
    return seed


@contextmanager
def episode_keys(generators: Sequence[np.random.Generator], chosen: NDArray[np.bool_]) -> Iterator[NDArray[np.uint64]]:
    """Keys (N, 2) of the chosen worlds' next episodes; what raises inside draws nothing from the generators.

    Args:
        generators: of each world; several worlds may share one.
        chosen: (N,) which worlds.
    """
    numbers = np.flatnonzero(chosen).tolist()
    states = [generators[i].bit_generator.state for i in numbers]
    keys = np.zeros((len(generators), 2), dtype=np.uint64)
    try:
        for i in numbers:
            keys[i] = generators[i].integers(0, 2**63, size=2, dtype=np.uint64)
        yield keys
    except BaseException:
        for i, state in zip(numbers, states, strict=True):
            generators[i].bit_generator.state = state
        raise
