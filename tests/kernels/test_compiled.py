"""Kernels from the cache are those of their own types, whichever process compiled them."""

import gc
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.extending import overload

import jawenv
from jawenv.base.errors import InputError
from jawenv.kernels import cache
from jawenv.kernels.compiled import WORLDS_AT_ONCE, njit, world_kernel
from tests.processes import python

SOURCES = Path(jawenv.__file__).parents[1]

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


def run(kernels: Path, kept: Path, *arguments: str, sources: Path = SOURCES, **options: Any) -> Any:
    """A process of this file, with its own cache."""
    return python(kernels, *arguments, env={"JAWENV_CACHE_DIR": str(kept), "PYTHONPATH": str(sources)}, **options)


def test_two_processes_may_fill_the_cache_for_a_third(tmp_path: Path) -> None:
    """Twice the sum of ones, of which a record has as many as its type says."""
    (tmp_path / "kernels.py").write_text(KERNELS)

    def sums(*sizes: str) -> list[float]:
        return [float(line) for line in run(tmp_path / "kernels.py", tmp_path / "cache", *sizes).stdout.split()]

    assert sums("3") == [6.0]
    assert sums("5") == [10.0]
    assert sums("3", "5") == [6.0, 10.0]
    assert sums("5", "3") == [10.0, 6.0]


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
    ran = run(folder / "kernels.py", cache)
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


def test_a_kernel_that_names_a_type_of_an_older_version_is_compiled_again(constant_cache: Path, tmp_path: Path) -> None:
    older = shutil.copytree(constant_cache, tmp_path / "cache")
    for file in older.rglob("*.kernel"):
        file.write_bytes(cache.with_checksum(b"cjawenv.kernels.lanes\nGone\n."))
    assert run_constant(tmp_path / "first", older, CONSTANT) == (3.0, True)
    assert run_constant(tmp_path / "again", older, CONSTANT) == (3.0, False)


@pytest.mark.skipif(os.name != "posix", reason="modes of POSIX")
@pytest.mark.parametrize("mode", [0o777, 0o775, 0o1777], ids=oct)
def test_a_cache_that_others_may_write_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: int) -> None:
    monkeypatch.setenv("JAWENV_CACHE_DIR", str(tmp_path))
    (tmp_path / "kernels").mkdir()
    (tmp_path / "kernels").chmod(mode)
    with pytest.raises(InputError, match=f"others may write in {tmp_path / 'kernels'}"):
        cache.cache_folder.__wrapped__()
    (tmp_path / "kernels").chmod(0o700)
    assert cache.cache_folder.__wrapped__() == tmp_path / "kernels"
    tmp_path.chmod(0o777)
    with pytest.raises(InputError, match="others may write"):
        cache.cache_folder.__wrapped__()


@pytest.mark.skipif(os.name != "posix", reason="modes of POSIX")
def test_a_new_cache_is_the_users_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = os.umask(0)
    try:
        cache._make(tmp_path / "jawenv" / "kernels" / "one")
    finally:
        os.umask(before)
    assert (tmp_path / "jawenv" / "kernels").stat().st_mode & 0o777 == 0o700
    assert (tmp_path / "jawenv").stat().st_mode & 0o777 == 0o700


def test_a_damaged_kernel_is_compiled_again(constant_cache: Path, tmp_path: Path) -> None:
    """Machine code with a flipped bit would end the process, and go on doing so."""
    damaged = shutil.copytree(constant_cache, tmp_path / "cache")
    for number, file in enumerate(sorted(damaged.rglob("*.kernel"))):
        content = bytearray(file.read_bytes())
        content[(number + 1) * len(content) // 5] ^= 4
        file.write_bytes(content)
    assert run_constant(tmp_path / "first", damaged, CONSTANT) == (3.0, True)
    assert run_constant(tmp_path / "again", damaged, CONSTANT) == (3.0, False)


def test_a_cache_without_locks_that_cannot_be_written_is_read(
    constant_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A container's, or a module system's; root may write everywhere, so that writing is made to fail."""

    def refuse(*arguments: Any, **options: Any) -> None:
        raise PermissionError(30, "Read-only file system")

    monkeypatch.setenv("JAWENV_CACHE_DIR", str(constant_cache))
    monkeypatch.setattr(cache, "cache_folder", lambda: constant_cache / "kernels")
    monkeypatch.setattr(cache.tempfile, "TemporaryFile", refuse)
    monkeypatch.setattr(cache.FileLock, "acquire", refuse)
    with cache.one_process(constant_cache, "anything"):
        pass

    @njit
    def other(x: float) -> float:
        return x

    (kept,) = (file for file in constant_cache.rglob("*.kernel") if ".outer" in file.parent.name)
    assert cache._checked_content(kept)
    with pytest.raises(jawenv.InputError):
        other(1.0)


def test_kernels_without_their_sources(tmp_path: Path) -> None:
    """In an installation of bytecode alone what is no kernel is known by its code."""
    for room in ("kernels", "base"):
        shutil.copytree(Path(jawenv.__file__).parent / room, tmp_path / "jawenv" / room)
    (tmp_path / "jawenv" / "__init__.py").touch()
    text = CONSTANT.replace("FACTOR * x", "cross((x, 0.0, 0.0), (0.0, 2.0, 0.0))[2]")
    (tmp_path / "kernels.py").write_text("from jawenv.kernels.vec3 import cross\n" + text)
    python("-m", "compileall", "-q", "-b", tmp_path)
    for source in tmp_path.rglob("*.py"):
        source.unlink()
    ran = run(tmp_path / "kernels.pyc", tmp_path / "cache", sources=tmp_path, cwd=tmp_path)
    assert float(ran.stdout) == 3.0


def test_compilation_that_is_switched_off_is_told_in_one_line() -> None:
    code = "import gymnasium, jawenv; gymnasium.make('jawenv/JawHinge-v3')"
    ran = python("-c", code, env={"NUMBA_DISABLE_JIT": "1"}, check=False)
    assert ran.returncode == 1 and "InputError: NUMBA_DISABLE_JIT is set; allowed" in ran.stderr.splitlines()[-1]


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

    def forms_after(name: str) -> tuple[float, set[str]]:
        ran = run(tmp_path / "kernels.py", tmp_path / "cache", name)
        folders = [file.parent.name for file in (tmp_path / "cache").rglob("*.kernel")]
        forms = {f"{folder.split('-')[0].split('.')[-1]}{'+' * folder.endswith('-linked')}" for folder in folders}
        return float(ran.stdout), forms

    assert forms_after("outer") == (3.0, {"outer", "inner+"})
    assert forms_after("other") == (1.0, {"outer", "other", "inner+"})
    assert forms_after("inner") == (2.0, {"outer", "other", "inner+", "inner"})


@pytest.mark.parametrize("collects", [True, False])
@pytest.mark.parametrize("kind", [njit, world_kernel(position=0)])
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


def test_worlds_are_shared_out_without_numbas_own_threads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Which would set the number of PyTorch's, once they begin."""
    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr("numba.np.ufunc.parallel._is_initialized", False)
    monkeypatch.setattr("numba.get_num_threads", lambda: pytest.fail("Numba's threads have begun"))

    @world_kernel(position=0)
    def count(worlds, part):
        for i in range(part[0], part[1]):
            worlds[i].number += 1.0

    worlds = np.zeros(3 * WORLDS_AT_ONCE, dtype=[("number", "f8")])
    count(worlds)
    assert (worlds["number"] == 1.0).all()
