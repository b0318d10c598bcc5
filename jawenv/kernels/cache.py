"""Where compiled kernels are kept: on disk, named by what they are made of.

Numba names a kernel's files by the path and the text of the source file. A copy of the sources then compiles all anew,
and a kernel is not renewed when one that it calls changes in another file. Here the name is a digest of the kernel's
own code and of all that it refers to: kernels that it calls, and the values of its constants. So a kernel is compiled
once for a machine, wherever the sources lie, and again only when its numbers could change.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import pickle
import shutil
import sys
import time
from collections.abc import Iterator
from functools import cache, cached_property
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numba
import numpy as np
from filelock import FileLock
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, _CacheLocator
from platformdirs import user_cache_dir

from jawenv.errors import InputError
from jawenv.kernels.linked import reading_linked

OPTIONS = "compiled_with"  # attribute of a kernel's Python function: what Numba was asked for
# What reading a damaged entry raises, or one for types that this version of jawenv does not have: it is made anew.
UNREADABLE = (pickle.UnpicklingError, ImportError, AttributeError, EOFError, LookupError, ValueError, TypeError)
UNUSED_DAYS = 30  # after which a kernel that was compiled is deleted


@cache
def cache_folder() -> Path:
    """Where compiled kernels are kept: ``JAWENV_CACHE_DIR``, or jawenv's folder in the user's cache."""
    root = os.environ.get("JAWENV_CACHE_DIR") or user_cache_dir("jawenv")
    return Path(root) / "kernels"


def kernel_folder(function: FunctionType, kind: str = "") -> Path:
    """The folder of one kernel: its name, the digest of what it is made of, and in which form it is compiled."""
    name = f"{function.__module__}.{function.__qualname__}-{kernel_digest(function)}{kind}"
    return cache_folder() / name.replace("<", "")


def prune_cache() -> None:
    """Delete kernels that nothing has used for ``UNUSED_DAYS``."""
    oldest = time.time() - UNUSED_DAYS * 86400
    for folder in cache_folder().iterdir():
        if folder.is_dir() and folder.stat().st_mtime < oldest:
            shutil.rmtree(folder, ignore_errors=True)


@cache
def kernel_digest(function: FunctionType) -> str:
    """Sixteen hexadecimal digits that change with the kernel, with what it calls and with Numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    seen: set[int] = set()
    pending: list[Any] = [function]
    while pending:
        part = pending.pop()
        if id(part) in seen:
            continue
        seen.add(id(part))
        digest.update(f"{part.__module__}.{part.__qualname__}{part.__dict__.get(OPTIONS)}".encode())
        for piece in _pieces_of(part.__code__, part.__doc__):
            digest.update(piece)
        for name, value in _references(part):
            called = _function_of(value)
            if called is not None:
                pending.append(called)
                if not hasattr(value, "py_func") and called.__module__.startswith("jawenv."):
                    text, others = _module_of(called)
                    digest.update(text)
                    pending += others
            digest.update(f"{name}={_text_of(value)}".encode())
    return digest.hexdigest()[:16]


def _pieces_of(code: CodeType, doc: str | None) -> Iterator[bytes]:
    """What a function's code says, without its documentation and line numbers."""
    yield code.co_code + repr((code.co_names, code.co_varnames, code.co_freevars)).encode()
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _pieces_of(constant, None)
        elif constant is not None and constant != doc:
            yield repr(constant).encode()


def _references(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Names of other things in a function's code, with what they stand for: in its module, or where it was made."""
    closure = inspect.getclosurevars(function)
    yield from sorted(closure.nonlocals.items())
    yield from sorted(closure.globals.items())
    # getclosurevars leaves out the members of modules of this package.
    for name, value in sorted(closure.globals.items()):
        if isinstance(value, ModuleType) and value.__name__.startswith("jawenv"):
            yield from (
                (f"{name}.{member}", getattr(value, member))
                for member in function.__code__.co_names
                if hasattr(value, member)
            )


def _function_of(value: Any) -> FunctionType | None:
    """The Python function behind a kernel, an intrinsic or a plain function of this package."""
    for holder in (getattr(value, "py_func", None), getattr(value, "_defn", None), value):
        if isinstance(holder, FunctionType):
            return holder
    return None


@cache
def _module_of(function: FunctionType) -> tuple[bytes, list[FunctionType]]:
    """The module of what is no kernel: its text and functions. What generates code may stand anywhere in it."""
    module = sys.modules[function.__module__]
    members = [_function_of(member) for _, member in sorted(vars(module).items())]
    functions = [member for member in members if member is not None and member.__module__ == module.__name__]
    return inspect.getsource(module).encode(), functions


def _text_of(value: Any) -> str:
    """A constant's value; what is not a constant has a name."""
    if (
        isinstance(value, int | float | complex | str | bytes | bool | tuple | frozenset | np.dtype | np.generic)
        or value is None
    ):
        return repr(value)
    if isinstance(value, np.ndarray):
        return f"{value.dtype}{value.shape}{hashlib.sha256(value.tobytes()).hexdigest()}"
    return f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', type(value).__qualname__)}"


class _DigestLocator(_CacheLocator):
    """Finds a kernel's files by its digest."""

    def __init__(self, function: FunctionType) -> None:
        self._function = function
        self._py_file = inspect.getfile(function)

    @classmethod
    def from_function(cls, py_func: FunctionType, py_file: str) -> _DigestLocator:
        locator = cls(py_func)
        try:
            locator.ensure_cache_path()
        except OSError as error:
            raise InputError(
                f"JAWENV_CACHE_DIR: compiled kernels cannot be kept in {cache_folder()} ({error.strerror}); "
                "allowed: a folder that can be written"
            ) from None
        return locator

    def get_cache_path(self) -> str:
        return str(kernel_folder(self._function, self._kind))

    _kind = ""

    def get_source_stamp(self) -> str:
        return kernel_digest(self._function)

    def get_disambiguator(self) -> str:
        return ""


class _SharedCacheFile(IndexDataCacheFile):
    """One kernel's entries in the cache, which several processes may add to at once.

    Numba reads the index, adds an entry and writes the index back. Two processes that save the kernel for two models at
    once would give both the same file, and a third process would be told that the kernel does not take its model.
    """

    def save(self, key: Any, data: Any) -> None:
        with FileLock(f"{self._index_path}.lock"):
            super().save(key, data)

    def load(self, key: Any) -> Any:
        try:
            return super().load(key)
        except UNREADABLE:
            return None

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except UNREADABLE:
            return {}


class _LinkedLocator(_DigestLocator):
    """The same of a kernel that is linked into others."""

    _kind = "-linked"


class _Implementation(CompileResultCacheImpl):
    _locator_classes: list[Any] = [_DigestLocator]


class _LinkedImplementation(CompileResultCacheImpl):
    _locator_classes: list[Any] = [_LinkedLocator]

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        with reading_linked(target_context):
            return super().rebuild(target_context, payload)


class _Files(FunctionCache):
    """Numba's cache of a function, in the folder of its digest."""

    _impl_class: type[CompileResultCacheImpl] = _Implementation

    def __init__(self, py_func: FunctionType) -> None:
        super().__init__(py_func)
        self._cache_file.__class__ = _SharedCacheFile


class _LinkedFiles(_Files):
    """The same of a kernel that is linked into others."""

    _impl_class = _LinkedImplementation


class KernelCache:
    """The cache of one kernel, found when the kernel is first called: only then is all there that it refers to.

    Args:
        function: the kernel's.
        linked: whether it is a kernel that only other kernels call (``linked``).
    """

    def __init__(self, function: FunctionType, linked: bool = False) -> None:
        """Remember the function; nothing is read."""
        self._function, self._linked = function, linked

    @cached_property
    def files(self) -> Any:
        """Numba's cache."""
        return _LinkedFiles(self._function) if self._linked else _Files(self._function)

    def __getattr__(self, name: str) -> Any:
        """All that Numba asks its cache for."""
        return getattr(self.files, name)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kernel for these types, None where it has to be compiled; then says so on stderr."""
        found = self.files.load_overload(sig, target_context)
        if found is None:
            say_compiling()
        return found


@cache
def say_compiling() -> None:
    """Say on stderr, once in a process, that kernels are being compiled."""
    print("jawenv: compiling for this machine, once (about a minute for a model) ...", file=sys.stderr, flush=True)
