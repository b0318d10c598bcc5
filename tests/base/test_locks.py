"""An output belongs to one process at a time."""

import subprocess
import sys
from pathlib import Path

import pytest
from filelock import FileLock

from jawenv.base.errors import InputError
from jawenv.base.locks import alone
from tests.processes import started

HOLDS = """
import sys
from pathlib import Path
from jawenv.base.locks import alone

with alone(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize("name", ["file.yaml", "folder"])
def test_another_process_is_refused_until_the_first_ends(tmp_path: Path, name: str) -> None:
    output = tmp_path / name
    command = [sys.executable, "-c", HOLDS, str(output)]
    with started(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None and other.stdout.readline() == "held\n"
        with pytest.raises(InputError) as refused, alone(output):
            pass
        assert "\n" not in str(refused.value)
    with alone(output), alone(tmp_path / "another"):
        pass
    assert not list(tmp_path.iterdir()), "no lock is left behind"


def test_it_is_free_after_an_error(tmp_path: Path) -> None:
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt), alone(tmp_path / "run"):
            raise KeyboardInterrupt


def test_the_folder_above_is_made_and_stays_if_something_was_written(tmp_path: Path) -> None:
    output = tmp_path / "new" / "runs" / "run"
    with alone(output):
        assert output.parent.is_dir() and not output.exists()
    assert not list(tmp_path.iterdir())
    with alone(output):
        output.write_text("whole")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [output]


def test_a_link_to_an_output_is_that_output(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "run")
    with alone(tmp_path / "run"), pytest.raises(InputError), alone(tmp_path / "link"):
        pass


def test_an_output_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError), alone(tmp_path / "file" / "run"):
        pass


def test_what_a_killed_process_was_writing_goes(tmp_path):
    folder = tmp_path / "out"
    (folder / "deeper").mkdir(parents=True)
    left = [folder / ".a.npz.0f.unfinished", tmp_path / ".out.0f.unfinished"]
    others = [folder / "deeper" / ".a.0f.unfinished", tmp_path / ".other.0f.unfinished", folder / "a.npz"]
    for path in (*left, *others):
        path.touch()
    with alone(folder):
        assert not any(path.exists() for path in left)
    assert all(path.exists() for path in others)


def test_a_file_system_without_locks_is_told_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(lock: FileLock) -> None:
        raise NotImplementedError("FileSystem does not appear to support flock")

    monkeypatch.setattr(FileLock, "acquire", refuse)
    with pytest.raises(InputError, match="its file system has no locks"), alone(tmp_path / "run"):
        pass
