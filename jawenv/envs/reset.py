"""What ``reset`` is given, checked: patients and seeds."""

from __future__ import annotations

from jawenv.anatomy import Patient
from jawenv.checks import whole_number
from jawenv.errors import InputError, shown
from jawenv.files import instance_of

__all__ = ["checked_patient", "checked_seed"]


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
