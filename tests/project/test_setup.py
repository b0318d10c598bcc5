"""The set-up script, run on a tiny project of its own, so that nothing is downloaded."""

import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from importlib.metadata import distribution
from pathlib import Path

import pytest

from tests.processes import started

ROOT = Path(__file__).parents[2]

PYPROJECT = """
[build-system]
requires = []
build-backend = "backend"
backend-path = ["."]

[project]
name = "jawenv"
version = "0.1.0"

[project.optional-dependencies]
all = []

[dependency-groups]
train = []
eval = []
"""

# The least that pip accepts as a build backend. While the file `slow` exists, a build never ends.
BACKEND = """
import pathlib, time, zipfile

def build_editable(folder, config_settings=None, metadata_directory=None):
    while pathlib.Path("slow").exists():
        pathlib.Path("building").touch()
        time.sleep(0.1)
    name = "jawenv-0.1.0-py3-none-any.whl"
    info = "jawenv-0.1.0.dist-info"
    with zipfile.ZipFile(pathlib.Path(folder) / name, "w") as wheel:
        wheel.writestr(f"{info}/METADATA", "Metadata-Version: 2.1\\nName: jawenv\\nVersion: 0.1.0\\n"
                       "Provides-Extra: all\\n")
        wheel.writestr(f"{info}/WHEEL", "Wheel-Version: 1.0\\nGenerator: test\\nRoot-Is-Purelib: true\\n"
                       "Tag: py3-none-any\\n")
        wheel.writestr(f"{info}/RECORD", f"{info}/METADATA,,\\n{info}/WHEEL,,\\n{info}/RECORD,,\\n")
    return name

build_wheel = build_editable
"""

PLAYED = """
import pathlib, time
from unittest.mock import MagicMock

def make(env_id, **options):
    while not pathlib.Path("goes on").exists():
        time.sleep(0.05)
    pathlib.Path("played").write_text(env_id)
    return MagicMock()
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "a project"  # a blank in the path, as users have them
    (folder / ".ci").mkdir(parents=True)
    shutil.copy(ROOT / ".ci" / "setup", folder / ".ci" / "setup")
    (folder / "pyproject.toml").write_text(PYPROJECT)
    (folder / "constraints.txt").write_text("numpy==2.0\n")
    (folder / "backend.py").write_text(BACKEND)
    pip = distribution("pip")
    with zipfile.ZipFile(folder / f"pip-{pip.version}-py3-none-any.whl", "w") as wheel:
        for file in pip.files or ():
            if ".." not in file.parts and file.suffix != ".pyc":
                wheel.write(str(file.locate()), str(file))
    return folder


def environment(project: Path, **variables: str) -> dict[str, str]:
    # The backend needs nothing, so pip need not make a second environment for it.
    offline = {"PIP_NO_BUILD_ISOLATION": "0", "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": project.as_uri()}
    return os.environ | offline | {"PYTHON": sys.executable} | variables


def set_up(project: Path, *groups: str, **variables: str) -> subprocess.CompletedProcess[str]:
    command = [str(project / ".ci" / "setup"), *groups]
    return subprocess.run(command, env=environment(project, **variables), capture_output=True, text=True, timeout=120)


def interrupt_while_building(project: Path, *groups: str) -> int:
    """Starts a set-up whose build never ends, and stops it there. Returns the exit status."""
    (project / "slow").touch()
    command = [str(project / ".ci" / "setup"), *groups]
    with started(command, env=environment(project)) as process:
        deadline = time.monotonic() + 100
        while not (project / "building").exists() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        process.wait(60)
    (project / "slow").unlink()
    return process.returncode


def test_the_life_of_a_venv(project: Path) -> None:
    assert interrupt_while_building(project, "train") != 0
    assert not (project / ".venv" / ".setup" / "train").exists()

    after = set_up(project, "train")
    assert after.returncode == 0, after.stdout + after.stderr
    assert "making .venv" in after.stdout and "installing jawenv[all] and train" in after.stdout

    more = set_up(project, "train", "eval")
    assert "installing jawenv[all] and train eval" in more.stdout and "making .venv" not in more.stdout
    for variables in ({}, {"PYTHON": ""}):
        assert set_up(project, "train", "eval", **variables).stdout == "set-up: .venv is ready (train eval)\n"

    (project / "constraints.txt").write_text("numpy==2.1\n")
    (project / "backend.py").write_text("raise RuntimeError('no such backend today')\n")
    failed = set_up(project, "eval")
    assert failed.returncode == 1 and "no such backend today" in failed.stderr
    assert "error: pip could not install" in failed.stderr and (project / ".venv" / ".unfinished").exists()


def test_kernels_are_compiled_while_the_rest_is_installed(project: Path) -> None:
    """By a step of Jaw-v3, here of a stand-in, which does not hold the lock of set-ups."""
    (project / "jawenv.py").touch()
    (project / "gymnasium.py").write_text(PLAYED)
    assert set_up(project, "train").returncode == 0 and not (project / "played").exists()
    shutil.rmtree(project / ".venv")
    after = set_up(project, "train", COMPILE="1")
    assert after.returncode == 0 and "compiling kernels meanwhile" in after.stdout, after.stdout + after.stderr
    assert "is ready" in set_up(project, "train", COMPILE="1").stdout
    assert not (project / "played").exists(), "it is still at work"
    (project / "goes on").touch()
    deadline = time.monotonic() + 60
    while not (project / "played").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert (project / "played").read_text() == "jawenv/Jaw-v3"


@pytest.mark.parametrize("exit_status", [1, None], ids=["too old", "none"])
def test_an_unusable_python_gets_one_line(project: Path, tmp_path: Path, exit_status: int | None) -> None:
    python = tmp_path / "python"
    if exit_status is not None:
        python.write_text(f"#!/bin/sh\nexit {exit_status}\n")
        python.chmod(0o755)
    result = set_up(project, "train", PYTHON=str(python))
    assert result.returncode == 1 and result.stderr.count("\n") == 1
    assert result.stderr.startswith(f"error: PYTHON is '{python}'; allowed: the path of a Python 3.11 or later")
    assert not (project / ".venv").exists()
