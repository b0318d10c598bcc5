"""The set-up script, run on a tiny project of its own, so that nothing is downloaded."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

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
train = []
eval = []

[tool.setuptools]
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
                       "Provides-Extra: train\\nProvides-Extra: eval\\n")
        wheel.writestr(f"{info}/WHEEL", "Wheel-Version: 1.0\\nGenerator: test\\nRoot-Is-Purelib: true\\n"
                       "Tag: py3-none-any\\n")
        wheel.writestr(f"{info}/RECORD", f"{info}/METADATA,,\\n{info}/WHEEL,,\\n{info}/RECORD,,\\n")
    return name

build_wheel = build_editable
"""

# A Python that answers the script's question as the named one would. It cannot do anything else.
FAKE_PYTHON = "#!/bin/sh\nprintf '%s\\t%s\\t%s\\n' {verdict} {path} {version}\n"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "a project"  # a blank in the path, as users have them
    (folder / ".ci").mkdir(parents=True)
    shutil.copy(ROOT / ".ci" / "setup", folder / ".ci" / "setup")
    (folder / "pyproject.toml").write_text(PYPROJECT)
    (folder / "constraints.txt").write_text("numpy==2.0\n")
    (folder / "backend.py").write_text(BACKEND)
    return folder


def environment(**variables: str) -> dict[str, str]:
    # The backend needs nothing, so pip need not make a second environment for it.
    inherited = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    return inherited | {"PIP_NO_BUILD_ISOLATION": "0"} | variables


def set_up(project: Path, *extras: str, **variables: str) -> subprocess.CompletedProcess[str]:
    variables = {"PYTHON": sys.executable} | variables
    command = [str(project / ".ci" / "setup"), *extras]
    return subprocess.run(command, env=environment(**variables), capture_output=True, text=True, timeout=120)


def fake_python(path: Path, verdict: str, version: str) -> Path:
    path.write_text(FAKE_PYTHON.format(verdict=verdict, path=path.name, version=version))
    path.chmod(0o755)
    return path


def folder_of_tools(folder: Path) -> Path:
    """Everything on the path that the script needs before it has found a Python, and no Python."""
    folder.mkdir()
    for tool in ("bash", "dirname", "cat", "grep"):
        (folder / tool).symlink_to(shutil.which(tool) or pytest.fail(f"this machine has no {tool}"))
    return folder


def interrupt_while_building(project: Path, *extras: str) -> tuple[int, str]:
    """Starts a set-up whose build never ends, and stops it there. Returns exit status and output."""
    (project / "slow").touch()
    command = [str(project / ".ci" / "setup"), *extras]
    variables = environment(PYTHON=sys.executable)
    with subprocess.Popen(command, env=variables, stdout=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 100
        while not (project / "building").exists() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        output, _ = process.communicate(timeout=60)
    (project / "slow").unlink()
    return process.returncode, output


def test_the_life_of_a_venv(project: Path) -> None:
    stamps = project / ".venv" / ".setup"
    ready = "set-up: .venv is ready (train eval)\n"
    elsewhere = project / "elsewhere"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(elsewhere)], check=True)
    elsewhere.rename(project / ".venv")

    status, output = interrupt_while_building(project, "train")
    assert "cannot be used: it was made in another folder" in output
    assert "interrupted" in output
    assert status == 130
    assert not (stamps / "train").exists()

    after = set_up(project, "train")
    assert after.returncode == 0, after.stderr
    assert "cannot be used: it was left unfinished" in after.stdout
    assert "installing jawenv[train]" in after.stdout

    more = set_up(project, "train", "eval")
    assert "installing jawenv[eval]" in more.stdout
    assert "making .venv" not in more.stdout
    assert set_up(project, "train", "eval").stdout == ready
    assert set_up(project, "train", "eval", PYTHON="").stdout == ready

    (project / "constraints.txt").write_text("numpy==2.1\n")
    (project / "backend.py").write_text("raise RuntimeError('no such backend today')\n")
    failed = set_up(project, "eval")
    assert failed.returncode == 1
    assert "installing jawenv[eval]" in failed.stdout
    assert "no such backend today" in failed.stderr
    assert "error: pip could not install jawenv[eval]" in failed.stderr
    assert (project / ".venv.unfinished").exists()


@pytest.mark.parametrize(
    ("verdict", "version", "message"),
    [
        ("old", "3.9.18", "Python 3.9.18 (python3) is too old: install Python 3.11 or later"),
        ("bare", "3.11.2", "Python 3.11.2 (python3) comes without venv: apt install python3-venv"),
    ],
)
@pytest.mark.parametrize("named", [True, False], ids=["named", "found"])
def test_an_unusable_python_gets_one_line(
    project: Path, tmp_path: Path, verdict: str, version: str, message: str, named: bool
) -> None:
    tools = folder_of_tools(tmp_path / "tools")
    python = fake_python((tmp_path if named else tools) / "python3", verdict, version)
    result = set_up(project, "train", PYTHON=str(python) if named else "", PATH=str(tools))
    assert result.returncode == 1
    assert result.stderr.startswith(f"error: {message}")
    assert "PYTHON=/path/to/python3" in result.stderr
    assert result.stderr.count("\n") == 1
    assert not (project / ".venv").exists()


def test_no_python_at_all(project: Path, tmp_path: Path) -> None:
    tools = folder_of_tools(tmp_path / "tools")
    result = set_up(project, "train", PYTHON="", PATH=str(tools))
    assert result.returncode == 1
    assert result.stderr.startswith("error: no Python found: install Python 3.11 or later")

    result = set_up(project, "train", PYTHON="/no/such/python")
    assert result.returncode == 1
    assert result.stderr == "error: PYTHON=/no/such/python does not run: name a Python 3.11 or later\n"
