"""Compilation of jawenv's kernels: Numba, kept on disk (``cache``), and shared out to threads by worlds."""

from __future__ import annotations

import hashlib
import importlib
import inspect
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache, cached_property, update_wrapper
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
import numba.extending
import numpy as np
from numba.np.ufunc import parallel

from jawenv.base.errors import InputError
from jawenv.kernels.cache import MADE_OF, OPTIONS, KernelCache, kernel_folder, one_process, prune_cache
from jawenv.kernels.compiler import TESTED_NUMBA, LinkedCompiler, quickly

Function = TypeVar("Function", bound=Callable[..., Any])


def _record_in_symbol(record: Any) -> tuple[str, tuple[object, ...]]:
    """Name of a record in the symbol of a compiled function that takes it: by its content.

    Numba's own name is a number that counts the types which the process has seen. Two processes that compile one kernel
    for two models then give both the same symbol; a third, which reads both from the cache, calls one for the other.
    """
    return type(record).__name__, (_content_number(record.name),)


@cache
def _content_number(text: str) -> int:
    return int(hashlib.sha256(text.encode()).hexdigest()[:15], 16)


setattr(numba.types.Record, "mangling_args", property(_record_in_symbol))  # noqa: B010 - declared as a method


LINKS = TESTED_NUMBA
"""Whether kernels are linked into others; with another Numba all are compiled."""


class Kernel:
    """A kernel in two forms, one for other kernels and one for Python, each compiled at its first use.

    What kernels call is linked into them (``compiler``); what Python calls is machine code with an entry for Python. An
    error that such a kernel raises has no values in its message: Numba keeps these with machine code.
    """

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        """Declare the kernel; it is compiled at its first call, or read from the cache."""
        update_wrapper(self, function)
        self.py_func, self._options = function, options
        self._inner: Any = _compile(function, linked=LINKS, **options)
        self._numba_type_ = numba.typeof(self._inner)  # what Numba takes it for in a kernel

    @cached_property
    def _outer(self) -> Callable[..., Any]:
        return _compile(self.py_func, **self._options) if LINKS else self._inner

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel from Python."""
        return self._outer(*arguments)


def njit(function: Function) -> Function:
    """Compile a kernel: no Python objects, no fast-math reordering, IEEE division, cached on disk."""
    return cast(Function, Kernel(function))


def njit_within(function: Function) -> Function:
    """The same for a kernel that becomes part of its caller's code, and is not compiled by itself.

    Numba optimises each kernel together with all that it calls, so that a chain of kernels in which each only calls the
    next takes as many times as long to compile as it is long.
    """
    return _compile(function, inline="always")


def njit_inlined(function: Function) -> Function:
    """The same for a small kernel that is optimised with each of its callers: what they share is computed once."""
    return cast(Function, Kernel(function, forceinline=True))


def where(
    condition: Callable[..., object], otherwise: Callable[..., Any] | str | None = None
) -> Callable[[Function], Function]:
    """Decorator of a kernel's part that is there only where the types say so, and becomes part of its caller.

    What is not there is not compiled: a filter that knows the anatomy exactly has no code for nuisances.

    Args:
        condition: of the types of some of the part's arguments, which it takes by their names.
        otherwise: the part elsewhere, with the same arguments; by default nothing is done. As a name
            (``module.part``, in one of ``cache.LAZY_MODULES``) it is loaded only where it is compiled.
    """
    asked = tuple(inspect.signature(condition).parameters)

    def decorate(function: Function) -> Function:
        names = tuple(inspect.signature(function).parameters)

        @cache
        def elsewhere() -> Callable[..., Any]:
            chosen = _named(otherwise) if isinstance(otherwise, str) else otherwise
            chosen = chosen or eval(f"lambda {', '.join(names)}: None")
            chosen.__annotations__ = function.__annotations__  # Numba compares the arguments' names and annotations
            return chosen

        def part(*arguments: Any) -> Any:
            raise NotImplementedError("only called by compiled kernels")

        def choose(*types: Any) -> Any:
            by_name = dict(zip(names, types, strict=True))
            return function if condition(*(by_name[name] for name in asked)) else elsewhere()

        update_wrapper(part, function)
        other = otherwise.rpartition(".")[0] if isinstance(otherwise, str) else otherwise
        part.__dict__[MADE_OF] = tuple(piece for piece in (function, other, condition) if piece is not None)
        # Else each part, which is inlined, would be compiled to machine code first.
        options: Any = {"jit_options": LINKED} if LINKS else {}
        numba.extending.overload(part, inline="always", **options)(update_wrapper(choose, function))
        return cast(Function, part)

    return decorate


def _named(name: str) -> Callable[..., Any]:
    """The Python function of a part that is named with its module."""
    module, _, part = name.rpartition(".")
    value: Any = getattr(importlib.import_module(module), part)
    function: Callable[..., Any] = getattr(value, "py_func", value)
    return function


WORLDS_AT_ONCE = 8  # that a thread takes: few enough to leave some to others where it is held up


class WorldKernel:
    """A kernel that loops over worlds, shared out to threads where there are many of them.

    Each thread takes the next few worlds when it is done with the last, so that none waits for one whose core is busy.
    The kernel's last argument, ``part``, says which worlds it is to take, and whose working memory: first, one past the
    last, number of the thread. ``arguments[place]`` is one that has an entry per world. There are as many threads as
    ``numba.get_num_threads()`` says.
    """

    def __init__(self, function: Callable[..., None], position: int) -> None:
        """Declare the kernel; it is compiled at its first call, or read from the cache."""
        self._function: Any = function
        self._position = position
        self._begun: set[np.dtype[Any]] = set()
        self._kernel = _compile(function, nogil=True)

    def __call__(self, *arguments: Any) -> None:
        """Run the kernel on all worlds; says on stderr when it has to be compiled first."""
        worlds = arguments[self._position]
        if worlds.dtype not in self._begun:
            self._begin(worlds.dtype, arguments)
        threads = min(_number_of_threads(), len(worlds) // WORLDS_AT_ONCE)
        if threads < 2:
            self._kernel(*arguments, (0, len(worlds), 0))
            return
        first_worlds = iter(range(0, len(worlds), WORLDS_AT_ONCE))

        def work(thread: int) -> None:
            for first in first_worlds:
                self._kernel(*arguments, (first, min(first + WORLDS_AT_ONCE, len(worlds)), thread))

        shared = [_threads().submit(work, thread) for thread in range(1, threads)]
        try:
            work(0)
        finally:
            # An interrupt, too, finds no thread at work on the worlds.
            wait(shared)
        for future in shared:
            future.result()

    def _begin(self, dtype: np.dtype[Any], arguments: tuple[Any, ...]) -> None:
        """Compile or read the kernel for this model, by a call that takes no worlds."""
        # Of several processes one compiles, and the others read what it has saved.
        with one_process(kernel_folder(self._function), hashlib.sha256(repr(dtype).encode()).hexdigest()[:16]):
            self._kernel(*arguments, (0, 0, 0))
        prune_cache()
        self._begun.add(dtype)


def _number_of_threads() -> int:
    """Number of threads that ``numba.get_num_threads()`` states.

    That is asked only where Numba's own threads have begun, as `numba.set_num_threads` begins them. The question begins
    them too, and they set OpenMP's number, which is PyTorch's: ``torch.set_num_threads(1)`` would be undone.
    """
    config: Any = numba.config
    begun = getattr(parallel, "_is_initialized", True)
    number: int = numba.get_num_threads() if begun else config.NUMBA_NUM_THREADS
    return number


@cache
def _threads() -> ThreadPoolExecutor:
    """All but the calling thread, made when first needed."""
    config: Any = numba.config
    return ThreadPoolExecutor(max(1, config.NUMBA_NUM_THREADS - 1), thread_name_prefix="jawenv")


# A forked process has the executor, and none of its threads.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_threads.cache_clear)


def world_kernel(position: int) -> Callable[[Callable[..., None]], WorldKernel]:
    """Decorator that makes a ``WorldKernel``; ``position`` is the position of an argument with one entry per world."""
    return lambda function: WorldKernel(function, position)


LINKED = {"pipeline_class": LinkedCompiler, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Numba's options of a kernel for other kernels, into which it is linked."""


def _compile(function: Function, linked: bool = False, **options: Any) -> Function:
    config: Any = numba.config
    if config.DISABLE_JIT:
        raise InputError(
            "NUMBA_DISABLE_JIT is set; allowed: unset, since kernels have parts that only the compiler understands"
        )
    kernel = cast(FunctionType, function)
    kernel.__dict__[OPTIONS] = repr(sorted(options.items()))
    njit_as: Any = numba.njit
    compiled: Any = njit_as(error_model="numpy", **options, **(LINKED if linked else {}))(kernel)
    compiled._cache = KernelCache(kernel, linked)
    compiled._compiler.compile = quickly()(compiled._compiler.compile)
    return cast(Function, compiled)
