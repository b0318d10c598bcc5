"""What `pip install jawenv` brings."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DATA = (".toml", ".json", ".yaml")


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """The files of a wheel, built in a copy, so that the clone stays as it is."""
    copy = tmp_path_factory.mktemp("copy")
    for name in ("jawenv", "agents", "training", "eval"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, copy / name, ignore=ignored)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    build = "from setuptools import build_meta; build_meta.build_wheel('dist')"
    subprocess.run([sys.executable, "-c", build], cwd=copy, check=True, capture_output=True, timeout=120)
    (wheel,) = (copy / "dist").glob("*.whl")
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
