"""What results were made with."""

import subprocess
from pathlib import Path

from jawenv.base import versions


def git(folder: Path, *arguments: str) -> None:
    identity = ["-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", "-C", str(folder), *identity, *arguments], check=True, capture_output=True, timeout=600)


def test_a_new_file_is_a_change_unless_git_ignores_it(tmp_path: Path) -> None:
    git(tmp_path, "init")
    (tmp_path / ".gitignore").write_text("runs\n")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-m", "first")
    (tmp_path / "runs").write_text("")
    state = versions._git_state(tmp_path)
    assert state is not None and len(state["commit"]) == 40 and not state["changed"]
    (tmp_path / "new.py").write_text("")
    state = versions._git_state(tmp_path)
    assert state is not None and state["changed"]


def test_where_there_is_no_clone_nothing_is_said(tmp_path: Path) -> None:
    assert versions._git_state(tmp_path / "nowhere") is None


def test_all_is_together() -> None:
    about = versions.made_with(command="x")
    assert list(about) == ["command", "versions", "git", "machine"]
    assert {"python", *versions.PACKAGES} == set(about["versions"]) and about["machine"]["cores"] > 0
