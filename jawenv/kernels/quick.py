"""Less work for Numba while it compiles, for the same machine code: a first step takes a sixth less.

Each part replaces a function of Numba's within the block alone, and only of the version that this is tested with.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from typing import Any
from unittest.mock import patch

from numba import version_info
from numba.core import errors
from numba.core.targetconfig import TargetConfig
from numba.extending import overload
from numba.np import arrayobj

KNOWN = version_info.short == (0, 68)
"""Whether this is the Numba that jawenv is tested with."""


@contextmanager
def quickly() -> Iterator[None]:
    """Within it Numba compiles with less work."""
    with ExitStack() as stack:
        stack.enter_context(_without_collection())
        if KNOWN:
            stack.enter_context(patch.object(TargetConfig, "values", _values_of_options))
            stack.enter_context(patch.object(arrayobj, "raise_with_shape_context", _sizes_differ))
            stack.enter_context(patch.object(errors, "_termcolor_inst", _Plain()))
        yield


@contextmanager
def _without_collection() -> Iterator[None]:
    """Python collects no cycles: Numba makes millions of objects that stay, and each search goes over all."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _sizes_differ(source: Any, target: Any) -> None:
    """Raise Numba's error of a slice that is assigned something of another size, without the sizes in its message.

    Numba writes them with thirty kernels of Python's strings, which every process that compiles compiles anew.
    """


@overload(_sizes_differ)
def _overload_sizes_differ(source: Any, target: Any) -> Any:
    def differ(source: Any, target: Any) -> None:
        raise ValueError("cannot assign slice from input of different size")

    return differ


class _Plain:
    """No colours for error messages: Numba makes thousands of errors, of mismatched types, and shows none."""

    def __getattr__(self, name: str) -> Any:
        return str


def _values_of_options(flags: TargetConfig) -> dict[str, object]:
    """All options of Numba's flags, read at once; Numba compares flags wherever it looks up a function."""
    own: dict[str, object] = flags._values
    return _default_options(type(flags)) | own


@cache
def _default_options(kind: type[TargetConfig]) -> dict[str, object]:
    return {name: option.default for name, option in kind.options.items()}
