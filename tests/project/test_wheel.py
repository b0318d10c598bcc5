"""What `pip install jawenv` brings."""

import re
import shutil
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.processes import python

ROOT = Path(__file__).parents[2]
DATA = (".toml", ".json", ".yaml")
KERNEL = "jawenv/kernels/shipped/jawenv.kernels.noise.philox-0123456789abcdef/0123456789abcdef01234567.kernel"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wheel, built in a copy, so that the clone stays as it is."""
    copy = tmp_path_factory.mktemp("copy")
    for name in ("jawenv", "agents", "training", "eval"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, copy / name, ignore=ignored)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    (copy / KERNEL).parent.mkdir(parents=True, exist_ok=True)
    (copy / KERNEL).touch()
    (copy / "dist").mkdir()
    build = "from setuptools import build_meta; build_meta.build_wheel('dist')"
    python("-c", build, cwd=copy)
    (built,) = (copy / "dist").glob("*.whl")
    return built


@pytest.fixture(scope="module")
def names(wheel: Path) -> set[str]:
    """Its files."""
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_it_holds_jawenv_and_nothing_else(names: set[str]) -> None:
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"jawenv"}


def test_every_module_and_data_file_is_in_it(names: set[str]) -> None:
    library = ROOT / "jawenv"
    wanted = {
        str(path.relative_to(ROOT))
        for path in library.rglob("*")
        if path.suffix in (".py", *DATA) or path.name == "py.typed"
    }
    assert any(name.endswith(DATA) for name in wanted)
    assert "jawenv/py.typed" in wanted
    assert wanted <= names


def test_kernels_that_were_made_for_it_are_in_it(names: set[str]) -> None:
    assert KERNEL in names


def test_alone_it_brings_neither_pictures_nor_references(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (path,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = Parser().parsestr(archive.read(path).decode("utf-8"))
    required = [Requirement(line) for line in metadata.get_all("Requires-Dist", [])]
    alone = {one.name for one in required if one.marker is None or one.marker.evaluate({"extra": ""})}
    assert {"numpy", "numba", "gymnasium"} <= alone
    assert not alone & {"filterpy", "matplotlib", "pymunk", "pygame-ce", "torch", "pandas", "viser"}
    extras = {"sagittal", "mujoco", "render", "live", "mocap", "sb3", "all"}
    assert set(metadata.get_all("Provides-Extra", [])) == extras
    named = {extra for line in metadata.get_all("Requires-Dist", []) for extra in re.findall(r'extra == "(.+?)"', line)}
    assert named == extras
    assert metadata.get_payload().startswith("# jawenv")
