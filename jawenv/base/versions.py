"""The origin of results: packages, the commit of the clone, the machine."""

from __future__ import annotations

import contextlib
import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = (
    "jawenv",
    "gymnasium",
    "numpy",
    "numba",
    "llvmlite",
    "scipy",
    "pymunk",
    "torch",
    "stable-baselines3",
    "sb3-contrib",
)


def package_versions() -> dict[str, str]:
    """The installed version of each package, by its name."""
    installed = {}
    for package in PACKAGES:
        try:
            installed[package] = version(package)
        except PackageNotFoundError:
            installed[package] = "not installed"
    return installed


def made_with(**more: Any) -> dict[str, Any]:
    """A command's settings, versions of Python and the packages, the state of the clone, and the machine.

    ``git`` holds the commit and whether files differ from it, new ones that git does not ignore included; it is None
    where there is no clone, or no git.
    """
    versions = {"python": platform.python_version(), **package_versions()}
    return {**more, "versions": versions, "git": _git_state(Path(__file__).parents[2]), "machine": _machine()}


def _git_state(clone: Path) -> dict[str, Any] | None:
    answers = []
    for question in (("rev-parse", "HEAD"), ("status", "--porcelain")):
        command = ["git", "-C", str(clone), *question]
        try:
            asked = subprocess.run(command, capture_output=True, text=True, check=True, timeout=30)
        except (OSError, subprocess.SubprocessError):
            return None
        answers.append(asked.stdout.strip())
    return {"commit": answers[0], "changed": bool(answers[1])}


def _machine() -> dict[str, Any]:
    names = [platform.processor()]
    with contextlib.suppress(OSError):  # Linux alone has it
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")] + names
    return {"processor": names[0] or platform.machine(), "cores": os.cpu_count(), "system": platform.platform()}
