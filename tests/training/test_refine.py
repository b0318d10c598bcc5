"""The search by the twin's gradient: what it finds, the file that it writes, and what a stop leaves."""

import pytest

from jawenv.base.locks import alone
from jawenv.playing.maneuvers import Maneuver
from training.cli import main
from training.search import gradient

OPTIONS = ["--refine", "opening_with_swings", "--horizon-s", "2", "--patients", "2", "--updates", "2"]
COMMAND = ["refine", *OPTIONS, "--output"]


def test_the_command_writes_a_file_that_plays(tmp_path, capsys):
    output = tmp_path / "finer.yaml"
    assert main([*COMMAND, str(output)]) == 0
    text, maneuver = output.read_text(), Maneuver.load(output)
    assert maneuver.name == "finer" and maneuver.description.startswith("'opening_with_swings'")
    assert "--refine opening_with_swings" in text and "--horizon-s 2" in text
    assert main([*COMMAND, str(output)]) == 2 and "--overwrite" in capsys.readouterr().err
    assert main([*COMMAND, str(output), "--overwrite"]) == 0


def test_one_search_writes_a_file_at_a_time(tmp_path, capsys):
    output = tmp_path / "mine.yaml"
    with alone(output):
        assert main([*COMMAND, str(output)]) == 2
    assert "in use by another process" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["no/x.yaml", "My File.yaml", "x.toml"])
def test_what_cannot_be_written_is_refused_first(tmp_path, capsys, name):
    assert main([*COMMAND, str(tmp_path / name)]) == 2
    assert "--output" in capsys.readouterr().err


def test_a_search_that_was_stopped_leaves_nothing(tmp_path, capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(gradient, "searched", interrupted)
    assert main([*COMMAND, str(tmp_path / "mine.yaml")]) == 130
    assert "begins anew" in capsys.readouterr().err and not list(tmp_path.iterdir())
