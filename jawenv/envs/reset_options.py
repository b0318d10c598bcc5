"""Options of ``reset``, checked; loaded where some are given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Patient
from jawenv.base.errors import InputError, shown
from jawenv.base.files import instance_of
from jawenv.envs.asked import checked_asked
from jawenv.envs.configuration import Configuration

__all__ = [
    "checked_keys",
    "checked_mask",
    "checked_options",
    "checked_patient",
    "checked_patients",
    "checked_questions",
]


def checked_options(options: object, allowed: Sequence[str]) -> Mapping[str, Any]:
    """The options of ``reset``; empty for None."""
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise InputError(f"options is {shown(options)}; allowed: a mapping with {', '.join(allowed)}, or None")
    for name in options:
        if name not in allowed:
            raise InputError(f"option {shown(name)} is unknown; allowed: {', '.join(allowed)}")
    return options


def checked_patient(patient: object, name: str) -> Patient | None:
    """A patient given as a ``Patient``, as a mapping of its fields or as the path of a file; None draws one.

    Args:
        patient: what came from outside.
        name: what the message calls it.
    """
    return None if patient is None else instance_of(Patient, patient, name)


def checked_patients(patients: object, number: int) -> list[Patient | None]:
    """A patient or None for each of N worlds; none are given by None."""
    if patients is None:
        return [None] * number
    if isinstance(patients, str) or not isinstance(patients, Sequence):
        raise InputError(f"option patients is {shown(patients)}; allowed: a sequence of {number} entries")
    if len(patients) != number:
        raise InputError(f"option patients has {len(patients)} entries; allowed: {number}")
    return [checked_patient(patient, f"option patients[{i}]") for i, patient in enumerate(patients)]


def checked_questions(asked: object, number: int, configuration: Configuration) -> list[str | None]:
    """The question of each of N worlds, given for all or one by one; None for the configuration's."""
    questions = list(asked) if isinstance(asked, Sequence) and not isinstance(asked, str) else [asked] * number
    if len(questions) != number:
        raise InputError(f"option asked has {len(questions)} entries; allowed: {number}")
    if configuration.asked is None and any(question is not None for question in questions):
        raise InputError(f"option asked is {shown(asked)}; allowed in an environment with the argument asked alone")
    return [checked_asked(question, configuration.muscles.names, "option asked") for question in questions]


def checked_mask(mask: object, number: int) -> NDArray[np.bool_]:
    """Checked mask (N,) of the worlds that begin anew."""
    if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (number,):
        raise InputError(f"option reset_mask is {shown(mask)}; allowed: a bool array of shape ({number},)")
    return mask


def checked_keys(keys: object, shape: tuple[int, ...], name: str) -> NDArray[np.uint64] | None:
    """Keys of episodes that were played before, as ``info["episode_key"]`` has them; None draws new ones."""
    if keys is None:
        return None
    array = np.asarray(keys)
    if array.shape != shape or array.dtype.kind not in "iu" or (array < 0).any() or (array >= 2**63).any():
        raise InputError(
            f"option {name} is {shown(keys)}; allowed: info['episode_key'], whole numbers of shape {shape}"
        )
    return array.astype(np.uint64)
