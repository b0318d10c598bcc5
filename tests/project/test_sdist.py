"""The source distribution: all that the repository holds, and nothing else."""

import shutil
import subprocess
import tarfile
from pathlib import Path

import pytest

from tests.processes import python

ROOT = Path(__file__).parents[2]
STRAYS = (
    "jawenv/kernels/shipped/a.norm-0/0.kernel",
    "runs/old/report.html",
    ".venv/lib/x.py",
    "jawenv/__pycache__/a.cpython-311.pyc",
    "jawenv/notes.txt",
    "core.1",
)
BUILD = "from setuptools import build_meta; build_meta.build_sdist('dist')"


def tracked() -> list[str]:
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, timeout=600)
    if listed.returncode:
        pytest.skip("no repository")
    return [name for name in listed.stdout.split("\0") if name and (ROOT / name).exists()]


@pytest.fixture(scope="module")
def names(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """Its files, as built in a copy of the repository in which other things lie about."""
    copy = tmp_path_factory.mktemp("copy")
    for name in tracked():
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, copy / name)
    for name in STRAYS:
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        (copy / name).touch()
    (copy / "dist").mkdir()
    python("-c", BUILD, cwd=copy)
    (built,) = (copy / "dist").glob("*.tar.gz")
    with tarfile.open(built) as archive:
        return {member.name.split("/", 1)[1] for member in archive.getmembers() if member.isfile()}


def test_it_is_the_repository(names: set[str]) -> None:
    made = {name for name in names if name in ("PKG-INFO", "setup.cfg") or name.startswith("jawenv.egg-info/")}
    assert names - made == set(tracked())
