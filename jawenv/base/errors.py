"""The error that jawenv raises for input from outside, and how it shows a value."""

from __future__ import annotations

import difflib
import reprlib
import unicodedata
from collections.abc import Iterable

__all__ = [
    "InputError",
    "MissingPackageError",
    "UnknownArgumentError",
    "UnknownAttributeError",
    "meant",
    "not_among",
    "out_of_memory",
    "printable",
    "reason_of",
    "shown",
]

LONGEST_SHOWN_VALUE = 60
LONGEST_MESSAGE = 800

_REPR = reprlib.Repr()
# Longer than what is shown, so that the beginning of a value is shown and not its two ends.
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 4 * LONGEST_SHOWN_VALUE
_REPR.maxlist = _REPR.maxtuple = _REPR.maxdict = LONGEST_SHOWN_VALUE


class InputError(ValueError):
    """A value from outside (argument, file, action) is not usable.

    The message is one line that names the field, the value and what is allowed, so that command lines can
    print it as it stands: control characters of names from outside are escaped.
    """

    def __init__(self, message: object = "") -> None:
        """Keep the message, printable and of 800 characters at most."""
        text = printable(str(message))
        super().__init__(text if len(text) <= LONGEST_MESSAGE else text[: LONGEST_MESSAGE - 3] + "...")


class MissingPackageError(InputError, ImportError):
    """A package that only a part of jawenv needs is not installed; the message says how to install it."""


class UnknownArgumentError(InputError, TypeError):
    """An unknown keyword argument; a ``TypeError`` as well, which is what callers of a signature expect."""


class UnknownAttributeError(InputError, AttributeError):
    """An attribute that worlds do not have; an ``AttributeError`` as well, which callers of ``get_attr`` expect."""


def meant(name: str, names: Iterable[str]) -> str:
    """A question after the known names that are like an unknown one, with a blank at its end; empty if none is."""
    near = difflib.get_close_matches(name[:LONGEST_SHOWN_VALUE], names, n=3)
    return f"did you mean {' or '.join(near)}? " if near else ""


def not_among(field: str, value: object, names: Iterable[str], more: str = "") -> InputError:
    """The error of a name that is none of those allowed, with the names that are like it.

    Args:
        field: what has the value.
        value: what was given.
        names: what is allowed.
        more: what else is allowed, in words.
    """
    allowed = tuple(names)
    near = meant(value, allowed) if isinstance(value, str) else ""
    return InputError(f"{field} is {shown(value)}; {near}allowed: {', '.join(allowed)}{more}")


def out_of_memory(error: MemoryError) -> str:
    """A command's message when memory is too small, without the description of the array."""
    reason = str(error).partition(" for an array")[0]
    return f"too little memory{': ' if reason else ''}{reason}"


def printable(text: str) -> str:
    """A text in one line: characters that steer a terminal or turn the direction of writing become escapes."""
    if text.isprintable():
        return text
    return "".join(
        one.encode("unicode_escape").decode() if unicodedata.category(one) in _STEERING else one for one in text
    )


_STEERING = ("Cc", "Cf", "Cs", "Zl", "Zp")  # control, format, half of a pair, ends of line and paragraph


def reason_of(error: Exception) -> str:
    """The system's words for an error; errors that Python raises in its place have no ``strerror``."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__


def shown(value: object) -> str:
    """A value as messages show it: its repr in one line, of 60 characters at most."""
    try:
        text = " ".join(_REPR.repr(value).split())
    except ValueError:  # Python writes out no integer of more than some thousand digits
        text = "an integer too long to show"
    return text if len(text) <= LONGEST_SHOWN_VALUE else text[: LONGEST_SHOWN_VALUE - 3] + "..."
