"""Kernels from the cache are those of their own types, whichever process compiled them."""

import gc
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.caching import IndexDataCacheFile
from numba.core.compiler import Flags
from numba.extending import overload

import jawenv
from jawenv.kernels import cache
from jawenv.kernels.compiled import njit, world_kernel

# The inner kernel calls itself, and so stays a function of its own, which the outer calls by its symbol.
KERNELS = """
import sys

import numpy as np

from jawenv.kernels.compiled import njit


@njit
def total(record, times):
    if times == 0:
        return 0.0
    value = 0.0
    for i in range(record.values.shape[0]):
        value += record.values[i]
    return value + total(record, times - 1)


@njit
def outer(records, times):
    return total(records[0], times)


for size in sys.argv[1:]:
    records = np.ones(1, dtype=np.dtype([("values", "f8", int(size))]))
    print(outer(records, 2))
"""


def test_two_processes_may_fill_the_cache_for_a_third(tmp_path: Path) -> None:
    """Twice the sum of ones, of which a record has as many as its type says."""
    (tmp_path / "kernels.py").write_text(KERNELS)
    places = {"JAWENV_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(jawenv.__file__).parents[1])}

    def sums(*sizes: str) -> list[float]:
        command = [sys.executable, str(tmp_path / "kernels.py"), *sizes]
        ran = subprocess.run(command, env=os.environ | places, capture_output=True, text=True, check=True)
        return [float(line) for line in ran.stdout.split()]

    assert sums("3") == [6.0]
    assert sums("5") == [10.0]
    assert sums("3", "5") == [6.0, 10.0]
    assert sums("5", "3") == [10.0, 6.0]


def test_processes_that_save_at_once_keep_all_that_they_saved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba's own file, with no lock, gives both the same name here: the slow writing makes sure that they meet."""

    @njit
    def kernel() -> None:
        pass

    write: Any = IndexDataCacheFile._save_index

    def write_slowly(file: IndexDataCacheFile, entries: dict[str, str]) -> None:
        time.sleep(0.2)
        write(file, entries)

    monkeypatch.setattr(IndexDataCacheFile, "_save_index", write_slowly)
    shared: Any = type(kernel._outer._cache._cache_file)  # type: ignore[attr-defined]

    def kept(kind: Any, folder: Path) -> list[object]:
        folder.mkdir()
        files = [kind(str(folder), "kernel", "stamp") for _ in range(4)]
        with ThreadPoolExecutor(4) as threads:
            list(threads.map(lambda i: files[i].save(f"model {i}", i), range(4)))
        return [files[0].load(f"model {i}") for i in range(4)]

    assert kept(shared, tmp_path / "shared") == [0, 1, 2, 3]
    assert kept(IndexDataCacheFile, tmp_path / "alone") != [0, 1, 2, 3]


CONSTANT = """
from jawenv.kernels.compiled import njit

FACTOR = 2.0


@njit
def inner(x):
    return FACTOR * x


@njit
def outer(x):
    return inner(x) + 1.0


print(outer(1.0))
"""


def run_constant(folder: Path, cache: Path, text: str) -> tuple[float, bool]:
    """What kernels of this ``text`` print, and whether they were compiled for it: then stderr says so."""
    folder.mkdir()
    (folder / "kernels.py").write_text(text)
    places = {"JAWENV_CACHE_DIR": str(cache), "PYTHONPATH": str(Path(jawenv.__file__).parents[1])}
    command = [sys.executable, str(folder / "kernels.py")]
    ran = subprocess.run(command, env=os.environ | places, capture_output=True, text=True, check=True)
    return float(ran.stdout), "compiling" in ran.stderr


@pytest.fixture(scope="module")
def constant_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The cache after the kernels of ``CONSTANT`` were compiled; tests that add to it make a copy."""
    folder = tmp_path_factory.mktemp("constant")
    assert run_constant(folder / "first", folder / "cache", CONSTANT) == (3.0, True)
    return folder / "cache"


@pytest.mark.parametrize(
    ("old", "new", "value", "compiles"),
    [
        ("@njit", "@njit", 3.0, False),
        ("@njit", "# a remark\n@njit", 3.0, False),
        ("def outer(x):", 'def outer(x):\n    """Says what it is."""', 3.0, False),
        ("FACTOR = 2.0", "FACTOR = 3.0", 4.0, True),
        ("FACTOR * x", "FACTOR + x", 4.0, True),
    ],
)
def test_a_kernel_is_compiled_again_only_where_its_numbers_could_change(
    constant_cache: Path, tmp_path: Path, old: str, new: str, value: float, compiles: bool
) -> None:
    """In another folder, as in another clone."""
    shutil.copytree(constant_cache, tmp_path / "cache")
    text = CONSTANT.replace(old, new)
    assert run_constant(tmp_path / "clone", tmp_path / "cache", text) == (value, compiles)


LINKED = """
import sys

from jawenv.kernels.compiled import njit


@njit
def inner(x):
    return 2.0 * x


@njit
def outer(x):
    return inner(x) + 1.0


@njit
def other(x):
    return inner(x) - 1.0


for name in sys.argv[1:]:
    print(globals()[name](1.0))
"""


def test_a_kernel_has_machine_code_only_where_python_calls_it(tmp_path: Path) -> None:
    """Its form for other kernels is read from the cache by one that is compiled later, in another process."""
    (tmp_path / "kernels.py").write_text(LINKED)
    places = {"JAWENV_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(jawenv.__file__).parents[1])}

    def run(name: str) -> tuple[float, set[str]]:
        command = [sys.executable, str(tmp_path / "kernels.py"), name]
        ran = subprocess.run(command, env=os.environ | places, capture_output=True, text=True, check=True)
        folders = [file.parent.name for file in (tmp_path / "cache").rglob("*.nbc")]
        forms = {f"{folder.split('-')[0].split('.')[-1]}{'+' * folder.endswith('-linked')}" for folder in folders}
        return float(ran.stdout), forms

    assert run("outer") == (3.0, {"outer", "inner+"})
    assert run("other") == (1.0, {"outer", "other", "inner+"})
    assert run("inner") == (2.0, {"outer", "other", "inner+", "inner"})


def test_flags_compare_by_every_option() -> None:
    """Numba finds what it has compiled by its flags, the options that nobody has set among them."""
    flags, other = Flags(), Flags()
    flags.release_gil = True
    assert flags.values() == {name: getattr(flags, name) for name in flags.options}
    assert flags != other and flags == flags.copy()
    other.release_gil = True
    other.forceinline = Flags.options["forceinline"].default
    assert flags == other and hash(flags) == hash(other)


@pytest.mark.parametrize("collects", [True, False])
@pytest.mark.parametrize("kind", [njit, world_kernel(place=0)])
def test_no_cycles_are_collected_while_a_kernel_compiles(
    kind: Any, collects: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    seen = []

    def look() -> None:
        pass

    @overload(look)
    def _look_while_compiling() -> Any:
        seen.append(gc.isenabled())
        return lambda: None

    @kind
    def count(worlds, part):
        look()
        for i in range(part[0], part[1]):
            worlds[i].number += 1.0

    worlds = np.zeros(3, dtype=[("number", "f8")])
    before = gc.isenabled()
    try:
        (gc.enable if collects else gc.disable)()
        count(worlds) if kind is not njit else count(worlds, (0, 3, 0))
        assert seen and not any(seen) and gc.isenabled() == collects
    finally:
        (gc.enable if before else gc.disable)()
    assert (worlds["number"] == 1.0).all()
