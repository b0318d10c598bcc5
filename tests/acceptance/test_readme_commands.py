"""README's commands run as they are printed, one after the other, in a shell that began with its first block."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

from tests.project.documented import ROOT, blocks

FEW = {"--patients": 2, "--steps": 1, "--n-envs": 2}
"""Options that say how many; a command that has one of them gets it, behind those that are printed."""
OF_PROGRAMS = {"make": "--dry-run", "pip": "--dry-run --no-deps --no-build-isolation", "source": ""}
"""What others get, which would install packages or wait for a person."""


def printed() -> list[list[str]]:
    """Lines of README's blocks, without comments."""
    found = []
    for block in blocks(ROOT / "README.md", "sh"):
        lines = block.text.replace("\\\n", " ").splitlines()
        found.append([line.partition("  #")[0].strip() for line in lines if shlex.split(line, comments=True)])
    return found


def bash(script: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", "-euo", "pipefail", "-c", script],
        cwd=folder,
        env={"PATH": "/usr/bin:/bin", "HOME": os.environ["HOME"], "PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1"}
        | {name: value for name, value in os.environ.items() if name.startswith("JAWENV_")},
        capture_output=True,
        text=True,
        timeout=3000,
    )


def small(line: str, began: str, folder: Path) -> str:
    """A line as it is, and behind it the options that make it small."""
    program = shlex.split(line)[0]
    if program in OF_PROGRAMS:
        return f"{line} {OF_PROGRAMS[program]}"
    help = bash(f"{began}\n{line} --help", folder)
    assert help.returncode == 0, f"{line}: {help.stderr}"
    return " ".join([line, *(f"{name} {value}" for name, value in FEW.items() if f"{name} " in help.stdout)])


def test_every_line_of_readme_runs_in_the_shell_that_its_first_block_made(tmp_path: Path) -> None:
    for path in ROOT.iterdir():
        if path.name not in ("runs", ".git", ".venv"):
            (tmp_path / path.name).symlink_to(path)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    first, *rest = printed()
    began = "\n".join(small(line, "", tmp_path) for line in first)
    lines = [small(line, f"{{\n{began}\n}} > /dev/null", tmp_path) for block in rest for line in block]
    assert len(lines) > 8
    said = bash("\n".join([began, *(f"echo '$' {shlex.quote(line)} >&2\n{line}" for line in lines)]), tmp_path)
    assert said.returncode == 0, f"{said.stderr[-3000:]}\n{said.stdout[-1000:]}"
    assert (tmp_path / "runs" / "my_study" / "report.html").is_file()
