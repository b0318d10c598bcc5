"""Answers: none overwrites a file that was read, and one goes to the terminal alone."""

import json

import pytest

from jawenv.commands.app import main
from tests.stretched_logs import log_of, patient, written

COHORT = '{"name": "mine", "groups": [{"left": {"F_o_N": 2, "F_o_sd": 0.5, "b": 7, "b_sd": 0.3}}]}'
KNOWLEDGE = '{"mass": 0.05}'


@pytest.mark.parametrize(
    ("command", "option", "text"),
    [
        (["identify", "a.csv", "--json", "x.json"], "--cohort", COHORT),
        (["identify", "a.csv", "--json", "x.json"], "--knowledge", KNOWLEDGE),
        (["identify", "a.csv", "b.csv", "--json", "x.json"], "--cohort", COHORT),
        (["suggest", "a.csv", "--overwrite", "-o", "x.yaml"], "--cohort", COHORT),
        (["suggest", "a.csv", "--overwrite", "-o", "x.yaml"], "--columns", "{}"),
    ],
)
def test_an_answer_overwrites_no_option_that_is_a_file(tmp_path, monkeypatch, capsys, command, option, text):
    monkeypatch.chdir(tmp_path)
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("time_s,mouthpiece_z_mm\n0,-37\n0.01,-37\n", encoding="utf-8")
    output = tmp_path / command[-1]
    output.write_text(text, encoding="utf-8")
    assert main([*command, option, output.name]) == 2
    assert "allowed: an output that is no input" in capsys.readouterr().err
    assert output.read_text(encoding="utf-8") == text


def test_an_answer_on_the_terminal_stands_there_alone(tmp_path, capsys):
    written(log_of(patient()), tmp_path / "log.csv")
    assert main(["identify", str(tmp_path / "log.csv"), "--cohort", "trismus", "--json", "-"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["believed"] and "pull of the closed jaw" in said.err


def test_a_device_is_no_place_for_an_answer(tmp_path, capsys):
    written(log_of(patient()), tmp_path / "log.csv")
    assert main(["identify", str(tmp_path / "log.csv"), "--cohort", "trismus", "--json", "/dev/stdout"]) == 2
    assert "error: /dev/stdout: lies among devices; allowed: a file" in capsys.readouterr().err
