"""Work in parts: what is on disk is not done again, in one process or several, also after an interrupt."""

import io
import os
import re
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from rich.console import Console

from eval.kept.cells import Cell
from eval.kept.parts import Part, Run, finish
from eval.rows.times import Times
from jawenv.base.errors import InputError
from jawenv.base.files import atomic_write
from jawenv.base.locks import alone
from jawenv.base.progress import Progress
from tests.processes import started

ROOT = Path(__file__).parents[3]

INTERRUPTED_RUN = """
import sys
from pathlib import Path
from eval.kept.parts import Run, finish
from tests.eval.kept.test_parts import parts_in, slow_work, text_of

finish(parts_in(Path(sys.argv[1]), 200), slow_work, text_of, "items", Run(workers=2))
"""


def parts_in(folder: Path, number: int) -> list[Part]:
    return [Part("toy", i, 1, folder / f"{i}.txt") for i in range(number)]


def text_of(part: Part) -> str:
    return part.path.read_text()


def write_process(part: Part, progress: Progress) -> None:
    part.path.write_text(str(os.getpid()))


def slow_work(part: Part, progress: Progress) -> None:
    time.sleep(0.2)
    with atomic_write(part.path) as unfinished:
        unfinished.write_text("whole")


def refuse(part: Part, progress: Progress) -> None:
    raise InputError(f"part {part.first} is refused")


def note_files(part: Part, progress: Progress, done: list[str]) -> None:
    done.append(part.path.name)
    part.path.write_text("")


def test_only_missing_files_are_made(tmp_path):
    parts = [Part("toy", i, 5, tmp_path / f"{i}.txt") for i in range(4)]
    (tmp_path / "0.txt").write_text("")
    done, out = [], io.StringIO()
    finish(parts, partial(note_files, done=done), text_of, "draws", Run(workers=1, console=Console(file=out)))
    assert done == ["1.txt", "2.txt", "3.txt"]
    assert out.getvalue().splitlines()[:2] == ["making 20 draws", "5 of 20 draws kept from an earlier run"]
    finish(parts, partial(note_files, done=done), text_of, "draws", Run(workers=1))
    assert len(done) == 3
    finish(parts, partial(note_files, done=done), text_of, "draws", Run(True, 1))
    assert len(done) == 7


def test_processes_share_the_parts(tmp_path):
    finish(parts_in(tmp_path, 6), write_process, text_of, "items", Run(workers=2))
    processes = {path.read_text() for path in tmp_path.glob("*.txt")}
    assert len(list(tmp_path.glob("*.txt"))) == 6
    assert str(os.getpid()) not in processes


def test_a_refusal_in_a_process_is_the_callers(tmp_path):
    with pytest.raises(InputError):
        finish(parts_in(tmp_path, 4), refuse, text_of, "items", Run(workers=2))


def test_an_interrupt_ends_the_processes_and_leaves_whole_files(tmp_path):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))}
    command = [sys.executable, "-c", INTERRUPTED_RUN, str(tmp_path)]
    with started(command, env=environment, stderr=subprocess.PIPE) as process:
        for _ in range(300):
            if len(list(tmp_path.glob("*.txt"))) > 2:
                break
            assert process.poll() is None
            time.sleep(0.1)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        _, error = process.communicate(timeout=30)
    assert "KeyboardInterrupt" in error
    kept = list(tmp_path.glob("*.txt"))
    assert 2 < len(kept) < 200 and all(path.read_text() == "whole" for path in kept)
    time.sleep(1.0)
    assert len(list(tmp_path.glob("*.txt"))) == len(kept), "no process goes on"


def test_two_runs_do_not_work_in_one_folder(tmp_path):
    """The second says so; what is done already asks for no lock."""
    parts = parts_in(tmp_path, 2)
    with alone(tmp_path), pytest.raises(InputError):
        finish(parts, write_process, text_of, "items", Run(workers=1))
    finish(parts, write_process, text_of, "items", Run(workers=1))
    with alone(tmp_path):
        finish(parts, write_process, text_of, "items", Run(workers=1))


def test_parts_cover_all_patients_and_their_files_name_what_decides_them(tmp_path):
    parts = Cell({"entry": "a/b"}, None, range(5, 12), Times(0.1, 1.0), 3).parts(tmp_path)
    assert [(part.first, part.number) for part in parts] == [(5, 3), (8, 3), (11, 1)]
    assert re.fullmatch(r"a_b-00011-1-[0-9a-f]{16}\.parquet", parts[2].path.name)


def test_damage_is_found_before_anything_is_done_and_each_file_is_read_once(tmp_path):
    parts, done, read = parts_in(tmp_path, 3), [], []

    def careful(part: Part) -> str:
        read.append(part.path.name)
        if part.path.read_text() == "damaged":
            raise InputError(f"{part.path} is damaged")
        return part.path.stem

    (tmp_path / "2.txt").write_text("damaged")
    with pytest.raises(InputError):
        finish(parts, partial(note_files, done=done), careful, "items", Run(workers=1))
    assert not done
    (tmp_path / "2.txt").write_text("")
    read.clear()
    kept = finish(parts, partial(note_files, done=done), careful, "items", Run(workers=1))
    assert kept == ["0", "1", "2"] and done == ["0.txt", "1.txt"] and sorted(read) == ["0.txt", "1.txt", "2.txt"]
