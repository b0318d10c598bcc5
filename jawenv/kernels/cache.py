"""Compiled kernels kept on disk, named by what they are made of.

Numba names a kernel's files by the path and the text of the source file. A copy of the sources then compiles all anew,
and a kernel is not renewed when one that it calls changes in another file. Here the name is a digest of the kernel's
own code and of all that it refers to: kernels that it calls, and the values of its constants. So a kernel is compiled
once for a machine, wherever the sources lie, and again only when its numbers could change.

A wheel brings the kernels of common models, for each of ``LEVELS``, in a second folder that is only read.
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import inspect
import os
import pickle
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numba
import numpy as np
from filelock import FileLock
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from platformdirs import user_cache_dir

from jawenv.base.errors import InputError, reason_of
from jawenv.base.files import atomic_write
from jawenv.kernels.compiler import reading_linked

OPTIONS = "compiled_with"  # attribute of a kernel's Python function: what Numba was asked for
MADE_OF = "made_of"  # attribute of a kernel's part: the functions that it stands for, and names of ``LAZY_MODULES``
LAZY_MODULES = frozenset(
    {
        "jawenv.filter.bound.with_nuisances",
        "jawenv.filter.nuisances.changed_jaw",
        "jawenv.filter.nuisances.changes",
        "jawenv.filter.nuisances.without_cell",
    }
)
"""Modules of kernels that are loaded only where a model needs them (``compiled.where``): digests read their text."""
CHECKSUM_BYTES = 32  # sha256
UNUSED_DAYS = 30  # after which a kernel that was compiled is deleted
_V3 = "+avx,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe"
LEVELS = {"x86-64-v4": f"{_V3},+avx512bw,+avx512cd,+avx512dq,+avx512f,+avx512vl", "x86-64-v3": _V3}
"""Processors that a wheel brings kernels for -> what they can do; of those that fit, the first is taken."""


@cache
def cache_folder() -> Path:
    """Folder of compiled kernels, in ``JAWENV_CACHE_DIR`` or in jawenv's folder of the user's cache."""
    cache = Path(os.environ.get("JAWENV_CACHE_DIR") or user_cache_dir("jawenv"))
    return _own_folder("JAWENV_CACHE_DIR", cache / "kernels")


@cache
def shipped_folder() -> Path:
    """Folder of the kernels that jawenv came with: in the package, or ``JAWENV_KERNELS_DIR``."""
    named = os.environ.get("JAWENV_KERNELS_DIR")
    return _own_folder("JAWENV_KERNELS_DIR", Path(named)) if named else Path(__file__).with_name("shipped")


def _own_folder(name: str, folder: Path) -> Path:
    """A folder that a variable names, in which no others may write."""
    for place, sticky in ((folder, False), (folder.parent, True)):
        if _others_may_write(place, sticky):
            raise InputError(
                f"{name}: others may write in {place}, and machine code is run from it; "
                f"allowed: a folder of your own (chmod go-w {place}, if you trust what it holds)"
            )
    return folder


def _others_may_write(folder: Path, sticky: bool) -> bool:
    """Whether a user other than this one and root can write there; a sticky folder protects a folder within it."""
    try:
        status = folder.stat()
    except OSError:
        return False
    mine = os.name != "posix" or status.st_uid in (os.getuid(), 0)
    writable = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return not mine or bool(writable and not (sticky and status.st_mode & stat.S_ISVTX))


def kernel_folder(function: FunctionType) -> Path:
    """The folder of one kernel that Python calls."""
    return cache_folder() / _name_of(function)


def _name_of(function: FunctionType, kind: str = "") -> str:
    """Name of a kernel's folder: its own name, the digest of its sources, its form."""
    return f"{function.__module__}.{function.__qualname__}-{kernel_digest(function)}{kind}".replace("<", "")


def prune_cache() -> None:
    """Delete kernels that nothing has used for ``UNUSED_DAYS``."""
    oldest = time.time() - UNUSED_DAYS * 86400
    with suppress(OSError):  # another process prunes too, or the folder is only read
        for folder in cache_folder().iterdir():
            if folder.is_dir() and folder.stat().st_mtime < oldest:
                shutil.rmtree(folder, ignore_errors=True)


@cache
def kernel_digest(function: FunctionType) -> str:
    """Sixteen hexadecimal digits that change with the kernel, with what it calls and with Numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    seen: set[Any] = set()
    pending: list[Any] = [function]
    while pending:
        part = pending.pop()
        if part in seen:
            continue
        seen.add(part)
        if isinstance(part, str):
            pieces, references = _lazy_module(part)
        else:
            digest.update(f"{part.__module__}.{part.__qualname__}{part.__dict__.get(OPTIONS)}".encode())
            pieces, references = [*_pieces_of(part.__code__, part.__doc__)], [*_references(part)]
        for piece in pieces:
            digest.update(piece)
        for name, value in references:
            called = _function_of(value)
            module = value if isinstance(value, str) else getattr(called, "__module__", "")
            if module in LAZY_MODULES:
                pending.append(module)
            elif hasattr(value, MADE_OF):
                pending += getattr(value, MADE_OF)
            elif called is not None:
                pending.append(called)
                if not hasattr(value, "py_func") and called.__module__.startswith("jawenv."):
                    text, others = _module_of(called)
                    digest.update(text)
                    pending += others
            digest.update(f"{name}={_text_of(value)}".encode())
    return digest.hexdigest()[:16]


def _pieces_of(code: CodeType, doc: str | None) -> Iterator[bytes]:
    """The code of a function, without documentation and line numbers, in pieces."""
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


@cache
def _lazy_module(name: str) -> tuple[list[bytes], list[tuple[str, Any]]]:
    """Code of one of ``LAZY_MODULES``, which need not be loaded, and what its functions use of other modules."""
    spec: Any = find_spec(name)
    source = spec.loader.get_source(name)
    if source is None:  # an installation without sources, whose files do not change
        return [*_pieces_of(spec.loader.get_code(name), None)], []
    tree = ast.parse(source)
    code = compile(tree, name, "exec", dont_inherit=True, optimize=2)  # without documentation
    used = {used for function in code.co_consts if isinstance(function, CodeType) for used in function.co_names}
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    names = [(node.module, alias.name) for node in imports for alias in node.names if alias.name in used]
    return [*_pieces_of(code, None)], [(of, _of_module(module or "", of)) for module, of in names]


def _of_module(module: str, name: str) -> Any:
    """The value of a name in a module; for one of ``LAZY_MODULES`` the module's own name."""
    return module if module in LAZY_MODULES else getattr(importlib.import_module(module), name)


def _function_of(value: Any) -> FunctionType | None:
    """The Python function behind a kernel, an intrinsic or a plain function of this package."""
    for holder in (getattr(value, "py_func", None), getattr(value, "_defn", None), value):
        if isinstance(holder, FunctionType):
            return holder
    return None


@cache
def _module_of(function: FunctionType) -> tuple[bytes, list[FunctionType]]:
    """Text and functions of the module of a function that is no kernel: any part of it may generate code."""
    module = sys.modules[function.__module__]
    members = [_function_of(member) for _, member in sorted(vars(module).items())]
    functions = [member for member in members if member is not None and member.__module__ == module.__name__]
    try:
        text = inspect.getsource(module)
    except OSError:  # an installation without sources, whose files do not change
        text = ""
    return text.encode(), functions


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


class KernelCache:
    """Compiled forms of one kernel on disk: a file for each set of argument types, with a checksum at its beginning.

    Numba's own has an index beside these files, which two processes that save at once spoil for a third, and no
    checksum: machine code with a flipped bit ends the process. A damaged file is compiled anew.

    Args:
        function: the kernel's.
        linked: whether it is a kernel that only other kernels call (``compiler``).
    """

    def __init__(self, function: FunctionType, linked: bool = False) -> None:
        """Remember the function: what it refers to is there when the kernel is first called, and not before."""
        self._function, self._linked = function, linked

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kernel for these types, None where it has to be compiled; then says so on stderr."""
        target_context.refresh()
        processor = target_context.codegen().magic_tuple()
        path = cache_folder() / self._name(sig, processor)
        content = _checked_content(path) or self._shipped(sig, processor)
        reading = reading_linked(target_context) if self._linked else nullcontext()
        # One that names what is no longer there, a type of an older jawenv, is compiled anew.
        with reading, suppress(AttributeError, ImportError):
            if content is not None:
                return CompileResult._rebuild(target_context, *pickle.loads(content))
        _make_writable(path.parent)
        _say_compiling()
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel."""
        content = dumps(data._reduce())
        path = cache_folder() / self._name(sig, data.codegen.magic_tuple())
        with atomic_write(path, synced=False) as unfinished:  # a damaged file is compiled anew
            unfinished.write_bytes(with_checksum(content))

    def _shipped(self, sig: Any, processor: tuple[str, str, str]) -> bytes | None:
        """The kernel for a level that this processor reaches, if jawenv came with it."""
        system, _, features = processor
        for level, needed in LEVELS.items():
            if not self._linked and set(needed.split(",")) <= set(features.split(",")):
                content = _checked_content(shipped_folder() / self._name(sig, (system, level, needed)))
                if content is not None:
                    return content
        return None

    def _name(self, sig: Any, processor: tuple[str, str, str]) -> str:
        """A file for these types and this processor, in the kernel's folder."""
        python = f"{sys.implementation.name} {sys.version_info.major}.{sys.version_info.minor}"
        types = hashlib.sha256(repr((sig, processor, python)).encode()).hexdigest()
        return f"{_name_of(self._function, '-linked' if self._linked else '')}/{types[:24]}.kernel"


def with_checksum(content: bytes) -> bytes:
    """The content kept of a kernel, behind its checksum."""
    return hashlib.sha256(content).digest() + content


def _checked_content(path: Path) -> bytes | None:
    """A kept file's content behind its checksum; None if the file is missing or damaged."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    checksum, content = content[:CHECKSUM_BYTES], content[CHECKSUM_BYTES:]
    return content if hashlib.sha256(content).digest() == checksum else None


def _make(folder: Path) -> None:
    """Make a kernel's folder in a cache that is the user's alone, whatever the umask is."""
    for place in (folder.parent.parent, folder.parent):
        if not place.exists():
            place.mkdir(0o700, parents=True, exist_ok=True)
    folder.mkdir(exist_ok=True)


def _make_writable(folder: Path) -> None:
    """Make a kernel's folder."""
    try:
        _make(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"JAWENV_CACHE_DIR: compiled kernels cannot be kept in {cache_folder()} ({reason_of(error)}); "
            "allowed: a folder that can be written, or one that holds all that is played"
        ) from None


@contextmanager
def one_process(folder: Path, what: str) -> Iterator[None]:
    """Let one of several processes at a time into the block, where the folder can be written and has locks."""
    lock = FileLock(folder / f"{what}.lock")
    try:
        _make(folder)
        os.utime(folder)  # kernels in use are not pruned
        lock.acquire()
    except (OSError, NotImplementedError):
        yield
        return
    try:
        yield
    finally:
        lock.release()


@cache
def _say_compiling() -> None:
    """Say on stderr, once in a process, that kernels are being compiled."""
    print("jawenv: compiling, once for each kind of world (about a minute) ...", file=sys.stderr, flush=True)
