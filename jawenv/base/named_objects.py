"""Objects of the user's that are named as ``package.module:Name``."""

from __future__ import annotations

import importlib
import os
import re
import sys
from typing import Any

from jawenv.base.errors import InputError, MissingPackageError

_SPEC = re.compile(r"(?P<module>[^\W\d]\w*(?:\.[^\W\d]\w*)*):(?P<name>[^\W\d]\w*)")


def is_named(spec: str) -> bool:
    """Whether a text has the form ``package.module:Name``."""
    return _SPEC.fullmatch(spec) is not None


def import_named(spec: str, kind: str) -> Any:
    """The value that a spec names, installed or in the current folder.

    This runs the module: name only code of trusted origin.

    Args:
        spec: ``package.module:Name``.
        kind: what it is to be, for messages.
    """
    module, _, name = spec.partition(":")
    add_current_folder()
    try:
        imported = importlib.import_module(module)
    except MissingPackageError:
        raise
    except (Exception, SystemExit) as error:  # a module of the user's can raise anything, and end the program
        absent = error.name if isinstance(error, ModuleNotFoundError) else None
        if absent is not None and (module == absent or module.startswith(f"{absent}.")):
            raise no_module(spec, kind, absent) from None
        raise InputError(f"{kind} '{spec}': module '{module}' cannot be imported: {reason(error)}") from error
    if not hasattr(imported, name):
        raise InputError(f"{kind} '{spec}': module '{module}' has no '{name}'")
    return getattr(imported, name)


def add_current_folder() -> None:
    """Let modules of the current folder be imported."""
    if not {"", os.getcwd()} & set(sys.path):
        sys.path.append(os.getcwd())  # last: no file here shall stand in for an installed package


def no_module(spec: str, kind: str, module: str) -> InputError:
    """The error of a spec whose module does not exist."""
    return InputError(f"{kind} '{spec}': no module '{module}'; allowed: one in the current folder, or an installed one")


def reason(error: BaseException) -> str:
    """An error of the user's code in one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())[:160]}".removesuffix(": ")
