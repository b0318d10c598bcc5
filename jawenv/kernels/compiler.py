"""Numba's private parts: kernels that are linked into others, and less work while Numba compiles.

Numba optimises every kernel together with all that it calls, and makes machine code of it, with an entry for Python.
Where a kernel is called by kernels alone, each of these does all that again. Here such a kernel stays what can be
linked into others; only the outermost is optimised and becomes machine code, once. This and ``_sizes_differ`` are for
the version of Numba that they were tested with (``TESTED_NUMBA``). A first step takes, in s of a processor (``python -m
research.kernels``; two runs differ by 2):

| as it is | no kernel linked | cycles collected | sizes in an error's message |
|--:|--:|--:|--:|
| 42 | 95 | 49 | 48 |

Without the collection of cycles it takes 680 MB, and 400 with it.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

from llvmlite import binding
from numba import version_info
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.extending import overload
from numba.np import arrayobj

TESTED_NUMBA = version_info.short == (0, 68)
"""Whether this is the Numba that jawenv is tested with."""


class _WithoutEnvironments:
    """Numba's code generator for a library that is never executed, and so has no place for Python's objects."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def set_env(self, name: str, environment: Any) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)


class _LinkedLibrary(JITCodeLibrary):
    """The code of one kernel, to be linked into that of others.

    It is kept as LLVM's bytes, and read for each of these: as LLVM's objects it takes fifteen times as much memory.
    """

    _module: Any = None
    _code = b""

    @property
    def _final_module(self) -> Any:
        """Numba's name of the module: until it is finished, or one read anew."""
        return self._module or binding.parse_bitcode(self._code)

    @_final_module.setter
    def _final_module(self, module: Any) -> None:
        self._module = module

    def _optimize_final_module(self) -> None:
        """Left to what it is linked into."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True
        self._code = super()._get_module_for_linking().as_bitcode()
        self._module = self._shared_module = None

    def _get_module_for_linking(self) -> Any:
        self._ensure_finalized()
        return self._final_module

    def get_pointer_to_function(self, name: str) -> int:
        """0: there is no machine code."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        """Numba's code generator, without places for Python objects in the code."""
        return _WithoutEnvironments(self._codegen)

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        """The library's name and its LLVM code, which the cache keeps in place of machine code."""
        self._ensure_finalized()
        return self.name, "linked", self._code

    @classmethod
    def _unserialize(cls, codegen: Any, state: tuple[str, str, bytes]) -> _LinkedLibrary:
        name, _, code = state
        library = cls(codegen, name)
        library._final_module = binding.parse_bitcode(code)
        library._finalize_final_module()
        return library


class LinkedCompiler(Compiler):
    """Numba's compiler, for a kernel that other kernels call."""

    def define_pipelines(self) -> Any:
        """Numba's own passes, into a ``_LinkedLibrary``."""
        self.state.library = _LinkedLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return super().define_pipelines()


@contextmanager
def reading_linked(target: Any) -> Iterator[None]:
    """Within it the code that is read from the cache is a ``_LinkedLibrary``'s; Numba's compiler lock must be held."""
    codegen = target.codegen()
    usual = codegen._library_class
    codegen._library_class = _LinkedLibrary
    try:
        yield
    finally:
        codegen._library_class = usual


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


@contextmanager
def quickly() -> Iterator[None]:
    """Within it Numba compiles with less work."""
    with ExitStack() as stack:
        stack.enter_context(_without_collection())
        if TESTED_NUMBA:
            stack.enter_context(patch.object(arrayobj, "raise_with_shape_context", _sizes_differ))
        yield
