"""Kernels that a wheel brings: taken where they fit sources and processor, and else compiled as ever."""

import platform
import shutil
import sys
from pathlib import Path

import pytest
from llvmlite import binding

import jawenv
from jawenv.base.errors import InputError
from jawenv.kernels import cache
from research.kernels import make_cache, ship_cache
from tests.processes import python

HAS = {name for name, has in binding.get_host_cpu_features().items() if has}
REACHED = [level for level, needs in cache.LEVELS.items() if {need[1:] for need in needs.split(",")} <= HAS]
pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64" or not REACHED, reason="a processor of no level"
)

KERNELS = """
from math import exp

from jawenv.kernels.compiled import njit


@njit
def inner(x):
    return exp(0.3 * x)


@njit
def outer(x):
    return inner(x) / 3.0 + 0.1 * x
"""
USE = "import kernels; print(kernels.outer(0.7).hex())"


def run(folder: Path, shipped: Path, **environment: str) -> tuple[str, str]:
    """What the kernels in a folder print, and what is said on stderr, with an empty cache and shipped kernels."""
    places = {
        "JAWENV_CACHE_DIR": str(folder / "cache"),
        "JAWENV_KERNELS_DIR": str(shipped),
        "PYTHONPATH": f"{Path(jawenv.__file__).parents[1]}:{folder}",
    }
    ran = python("-c", USE, env=places | environment)
    return ran.stdout, ran.stderr


def written(folder: Path, text: str = KERNELS) -> Path:
    """A folder with these sources."""
    folder.mkdir(exist_ok=True)
    (folder / "kernels.py").write_text(text)
    return folder


@pytest.fixture(scope="module")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Machine code of the kernels for every level."""
    made = written(tmp_path_factory.mktemp("made"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", f"{Path(jawenv.__file__).parents[1]}:{made}")
        make_cache(str(made / "cache"), USE)
    assert ship_cache(made / "cache", made / "shipped") == len(cache.LEVELS)
    return made / "shipped"


@pytest.fixture(scope="module")
def compiled(shipped: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """What they print where they are compiled."""
    printed, said = run(written(tmp_path_factory.mktemp("compiled")), shipped.parent / "none")
    assert said.startswith("jawenv: compiling")
    return printed


@pytest.mark.parametrize("level", [None, *REACHED])
def test_a_shipped_kernel_is_used_and_gives_the_same_bits(
    shipped: Path, compiled: str, tmp_path: Path, level: str | None
) -> None:
    as_level = {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": cache.LEVELS[level]} if level else {}
    assert run(written(tmp_path), shipped, **as_level) == (compiled, "")
    assert not list(tmp_path.rglob("*.kernel"))


def test_one_of_other_sources_is_not_used(shipped: Path, compiled: str, tmp_path: Path) -> None:
    printed, said = run(written(tmp_path, KERNELS.replace("0.3", "0.4")), shipped)
    assert printed != compiled and said.splitlines() == [said.strip()] and said.startswith("jawenv: compiling")


def test_one_of_another_processor_is_not_used(shipped: Path, tmp_path: Path) -> None:
    older = {"NUMBA_CPU_NAME": "x86-64-v2", "NUMBA_CPU_FEATURES": "+sse4.2"}
    _, said = run(written(tmp_path), shipped, **older)
    assert said.splitlines() == [said.strip()] and said.startswith("jawenv: compiling")


def test_a_damaged_one_is_compiled(shipped: Path, compiled: str, tmp_path: Path) -> None:
    damaged = shutil.copytree(shipped, tmp_path / "shipped")
    for file in damaged.rglob("*.kernel"):
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 4
        file.write_bytes(content)
    printed, said = run(written(tmp_path), damaged)
    assert printed == compiled and said.startswith("jawenv: compiling")


def test_a_folder_in_which_others_may_write_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JAWENV_KERNELS_DIR", str(tmp_path))
    tmp_path.chmod(0o777)
    with pytest.raises(InputError, match=f"JAWENV_KERNELS_DIR: others may write in {tmp_path}"):
        cache.shipped_folder.__wrapped__()
    tmp_path.chmod(0o700)
    assert cache.shipped_folder.__wrapped__() == tmp_path
