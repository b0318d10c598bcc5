"""How jawenv compiles its kernels: Numba, cached on disk under a key made of the kernels' own source.

Numba renews a cached kernel when the file of that kernel changes, but not when a function that it calls changes in
another file. The cache folder is therefore named after a digest of all kernel sources: an edited or upgraded
jawenv compiles afresh, an unchanged one starts from the cache.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from platformdirs import user_cache_dir

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = Path(__file__).parent
_KERNEL_FOLDERS = ("mechanics", "device", "estimation", "envs")


@cache
def kernel_digest() -> str:
    """Sixteen hexadecimal digits that change with any kernel source or with Numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    sources = [Path(__file__), _PACKAGE / "noise.py"]
    for folder in _KERNEL_FOLDERS:
        sources += sorted((_PACKAGE / folder).glob("*.py"))
    for source in sources:
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()[:16]


@cache
def cache_folder() -> Path:
    """Where compiled kernels are kept: ``JAWENV_CACHE_DIR``, or jawenv's folder in the user's cache."""
    root = os.environ.get("JAWENV_CACHE_DIR") or user_cache_dir("jawenv")
    return Path(root) / "kernels" / kernel_digest()


def njit(function: Function) -> Function:
    """Compile a kernel: no Python objects, no fast-math reordering, IEEE division, cached on disk."""
    return _compile(function, parallel=False)


def njit_parallel(function: Function) -> Function:
    """Compile a kernel whose ``prange`` loop runs over worlds, one world on one thread."""
    return _compile(function, parallel=True)


def _compile(function: Function, parallel: bool) -> Function:
    previous = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        compiled: Function = numba.njit(cache=True, error_model="numpy", parallel=parallel)(function)
    finally:
        numba.config.CACHE_DIR = previous
    return compiled


def is_cached(kernel: Callable[..., Any]) -> bool:
    """Whether a compiled form of ``kernel`` lies in the cache, so that its first call needs no compilation."""
    return any(cache_folder().rglob(f"*{kernel.__name__}*.nbi"))
