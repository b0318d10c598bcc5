"""Packages that only a part of jawenv needs: they come with an extra of the wheel, or with a group of the clone."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from jawenv.base.errors import MissingPackageError


@contextmanager
def needs(user: str, package: str, extra: str = "", group: str = "") -> Iterator[None]:
    """Around the import of a package that may not be installed.

    Args:
        user: the part of jawenv that needs it, as the message names it.
        package: name that is imported.
        extra: the extra of jawenv that brings it.
        group: the group of the clone that brings it, where no extra does.

    Raises:
        MissingPackageError: the package is not installed. Whatever else its import raises passes through.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] != package:
            raise
        remedy = f'pip install "jawenv[{extra}]"' if extra else f".ci/setup {group}"
        raise MissingPackageError(f"{user} needs {package}: {remedy}") from None


def of_the_clone(user: str, module: str, group: str) -> Any:
    """A module of a package above the library, which a clone of the project has and the wheel has not.

    Args:
        user: the option that needs it, as the message names it.
        module: its name.
        group: the group of the clone that brings what it imports.

    Raises:
        MissingPackageError: it, or a package that it imports, is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        place = f"a clone of the project, with its extra {group} (.ci/setup {group})"
        raise MissingPackageError(f"{user}: {error.name} is not installed; allowed in {place}") from None
