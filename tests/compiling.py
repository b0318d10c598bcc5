"""Kernels of tests are compiled by processes of their own: in the one that compiles, Numba's objects stay."""

import os
import warnings
from typing import Any
from unittest.mock import patch
from weakref import WeakSet

from numba.core.dispatcher import _FunctionCompiler

from jawenv.kernels.cache import KernelCache
from jawenv.kernels.compiler import LinkedCompiler

_PARENT = os.getpid()
_compile_here, _save = _FunctionCompiler._compile_core, KernelCache.save_overload
_read: WeakSet[Any] = WeakSet()  # libraries of kernels that a child has saved


def apart() -> None:
    """From now on this process compiles no kernel itself, where it can fork."""
    if hasattr(os, "fork"):
        patch.object(_FunctionCompiler, "_compile_core", _compile).start()
        patch.object(KernelCache, "save_overload", _save_once).start()


def _compile(self: Any, args: Any, return_type: Any) -> Any:
    """Compile a kernel in a child, and read what that has saved; all else, and what fails there, as Numba does."""
    kernel = self.py_func.__module__.startswith("jawenv.") and self.pipeline_class is not LinkedCompiler
    if not kernel or os.getpid() != _PARENT or return_type is not None:
        return _compile_here(self, args, return_type)
    cache, context = KernelCache(self.py_func), self.targetdescr.target_context
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads, which wait for work and hold nothing
        child = os.fork()
    if child == 0:
        try:
            _save(cache, args, _compile_here(self, args, return_type))
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    compiled = cache.load_overload(args, context)
    if compiled is None:
        return _compile_here(self, args, return_type)
    context.insert_user_function(compiled.entry_point, compiled.fndesc, [compiled.library])
    _read.add(compiled.library)
    return compiled


def _save_once(self: KernelCache, sig: Any, data: Any) -> None:
    if data.library not in _read:
        _save(self, sig, data)
