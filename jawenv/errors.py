"""The error that jawenv raises for input from outside, and how it shows a value."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable

__all__ = [
    "InputError",
    "MissingPackageError",
    "UnknownArgumentError",
    "UnknownAttributeError",
    "meant",
    "out_of_memory",
    "shown",
]

LONGEST_SHOWN_VALUE = 60

_REPR = reprlib.Repr()
# Longer than what is shown, so that the beginning of a value is shown and not its two ends.
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 4 * LONGEST_SHOWN_VALUE
_REPR.maxlist = _REPR.maxtuple = _REPR.maxdict = LONGEST_SHOWN_VALUE


class InputError(ValueError):
    """A value from outside (argument, file, action) is not usable.

    The message is one line that names the field, the value and what is allowed, so that command lines can
    print it as it stands.
    """


class MissingPackageError(InputError, ImportError):
    """A package that only a part of jawenv needs is not installed; the message says how to install it."""


class UnknownArgumentError(InputError, TypeError):
    """A keyword argument that is not known; a ``TypeError`` as well, which is what callers of a signature expect."""


class UnknownAttributeError(InputError, AttributeError):
    """An attribute that worlds do not have; an ``AttributeError`` as well, which callers of ``get_attr`` expect."""


def meant(name: str, known: Iterable[str]) -> str:
    """A question after the known names that are like an unknown one, with a blank at its end; empty if none is."""
    near = difflib.get_close_matches(name, known, n=3)
    return f"did you mean {' or '.join(near)}? " if near else ""


def out_of_memory(error: MemoryError) -> str:
    """What a command says when there is too little memory, without the description of the array."""
    reason = str(error).partition(" for an array")[0]
    return f"too little memory{': ' if reason else ''}{reason}"


def shown(value: object) -> str:
    """A value as messages show it: its repr in one line, of 60 characters at most."""
    try:
        text = " ".join(_REPR.repr(value).split())
    except ValueError:  # Python writes out no integer of more than some thousand digits
        text = "an integer too long to show"
    return text if len(text) <= LONGEST_SHOWN_VALUE else text[: LONGEST_SHOWN_VALUE - 3] + "..."
