"""Packages that only a part of jawenv needs, and that come with an extra of the installation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from jawenv.errors import MissingPackageError

__all__ = ["needs"]


@contextmanager
def needs(user: str, package: str, extra: str) -> Iterator[None]:
    """Around the import of a package that may not be installed.

    Args:
        user: the part of jawenv that needs it, as the message names it.
        package: name that is imported.
        extra: the extra of jawenv that brings it.

    Raises:
        MissingPackageError: the package is not installed. Whatever else its import raises passes through.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] != package:
            raise
        raise MissingPackageError(f'{user} needs {package}: pip install "jawenv[{extra}]"') from None
