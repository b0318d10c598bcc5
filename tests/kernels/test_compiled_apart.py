"""A process that runs tests keeps none of what Numba makes while it compiles: others compile for it."""

import os
from types import FunctionType

import pytest
from numba.core import compiler

from jawenv.kernels import compiled, vec3


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes do not fork")
def test_a_kernel_is_compiled_by_a_child_and_read(tmp_path, monkeypatch):
    here, compile_extra = [], compiler.compile_extra
    monkeypatch.setattr("jawenv.kernels.cache.cache_folder", lambda: tmp_path)
    monkeypatch.setattr(
        compiler, "compile_extra", lambda *given, **more: here.append(1) or compile_extra(*given, **more)
    )
    cross = vec3.cross.py_func
    own = FunctionType(cross.__code__, cross.__globals__, "cross")
    kernel = compiled._compile(own)
    assert kernel((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)) == (0.0, 0.0, 1.0)
    assert not here
    (kept,) = tmp_path.rglob("*.kernel")
    assert kept.stat().st_size > 0
