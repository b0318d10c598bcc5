"""Work in chunks: what is on disk is not done again, in one process or several, also after an interrupt."""

import io
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from rich.console import Console

from eval.chunks import Chunk, finish, folder_for
from jawenv.errors import InputError
from jawenv.files import atomic_write
from jawenv.locks import alone

ROOT = Path(__file__).parents[2]

INTERRUPTED_RUN = """
import sys
from pathlib import Path
from eval.chunks import finish
from tests.eval.test_chunks import chunks_in, slow_work

finish(chunks_in(Path(sys.argv[1]), 40), slow_work, "items", workers=2)
"""


def chunks_in(folder: Path, number: int) -> list[Chunk]:
    return [Chunk("toy", i, 1, (("", folder / f"{i}.txt"),)) for i in range(number)]


def write_process(chunk: Chunk) -> None:
    for _, path in chunk.files:
        path.write_text(str(os.getpid()))


def slow_work(chunk: Chunk) -> None:
    time.sleep(0.2)
    for _, path in chunk.files:
        with atomic_write(path) as unfinished:
            unfinished.write_text("whole")


def refuse(chunk: Chunk) -> None:
    raise InputError(f"chunk {chunk.first} is refused")


def note_files(chunk: Chunk, done: list[str]) -> None:
    for part, path in chunk.files:
        done.append(f"{chunk.first} {part}")
        path.write_text("")


def test_only_missing_files_are_made(tmp_path):
    chunks = [Chunk("toy", i, 5, (("a", tmp_path / f"{i}a"), ("b", tmp_path / f"{i}b"))) for i in range(2)]
    (tmp_path / "0a").write_text("")
    done, out = [], io.StringIO()
    finish(chunks, partial(note_files, done=done), "draws", workers=1, console=Console(file=out))
    assert done == ["0 b", "1 a", "1 b"]
    assert out.getvalue().splitlines()[:2] == ["making 20 draws", "5 of 20 draws kept from an earlier run"]
    finish(chunks, partial(note_files, done=done), "draws", workers=1)
    assert len(done) == 3
    finish(chunks, partial(note_files, done=done), "draws", fresh=True, workers=1)
    assert len(done) == 7


def test_processes_share_the_chunks(tmp_path):
    finish(chunks_in(tmp_path, 6), write_process, "items", workers=2)
    processes = {path.read_text() for path in tmp_path.glob("*.txt")}
    assert len(list(tmp_path.glob("*.txt"))) == 6
    assert str(os.getpid()) not in processes


def test_a_refusal_in_a_process_is_the_callers(tmp_path):
    with pytest.raises(InputError, match="is refused"):
        finish(chunks_in(tmp_path, 4), refuse, "items", workers=2)


def test_an_interrupt_ends_the_processes_and_leaves_whole_files(tmp_path):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))}
    command = [sys.executable, "-c", INTERRUPTED_RUN, str(tmp_path)]
    process = subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True)
    for _ in range(300):
        if len(list(tmp_path.glob("*.txt"))) > 2:
            break
        assert process.poll() is None
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    _, error = process.communicate(timeout=30)
    assert "KeyboardInterrupt" in error
    kept = list(tmp_path.glob("*.txt"))
    assert 2 < len(kept) < 40 and all(path.read_text() == "whole" for path in kept)
    time.sleep(1.0)
    assert len(list(tmp_path.glob("*.txt"))) == len(kept), "no process goes on"


def test_an_output_that_is_a_file_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=f"output {tmp_path / 'file'}: Not a directory"):
        folder_for(tmp_path / "file", "chunks")


def test_two_runs_do_not_work_in_one_folder(tmp_path):
    """The second says so; what is done already asks for no lock."""
    chunks = chunks_in(tmp_path, 2)
    with alone(tmp_path), pytest.raises(InputError, match="in use by another process"):
        finish(chunks, write_process, "items", workers=1)
    finish(chunks, write_process, "items", workers=1)
    with alone(tmp_path):
        finish(chunks, write_process, "items", workers=1)
