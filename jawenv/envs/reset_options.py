"""What ``reset`` is given, checked: patients and seeds; and the random numbers that an episode begins with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Patient
from jawenv.checks import whole_number
from jawenv.errors import InputError, shown
from jawenv.files import instance_of

__all__ = ["checked_patient", "checked_seed", "episode_keys"]


def checked_patient(patient: object, name: str) -> Patient | None:
    """A patient given as a ``Patient``, as a mapping of its fields or as the path of a file; None draws one.

    Args:
        patient: what came from outside.
        name: what the message calls it.

    Raises:
        InputError: none of these, or a patient that is not usable.
    """
    return None if patient is None else instance_of(Patient, patient, name)


def checked_seed(value: object) -> int | None:
    """A seed as an int, or None.

    Raises:
        InputError: anything but a whole number, 0 or more.
    """
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
