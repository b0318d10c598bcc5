"""``jawenv identify`` on a log of force and opening."""

import json

import pytest

from jawenv.commands.app import main
from tests.stretched_logs import log_of, patient, written

TELLS = "This log tells how stiff the jaw is, not where."


@pytest.fixture
def log(tmp_path):
    written(log_of(patient()), tmp_path / "log.csv")
    return tmp_path / "log.csv"


def test_a_log_is_answered_with_its_curve(log, tmp_path, capsys):
    answer = tmp_path / "answer.json"
    assert main(["identify", str(log), "--cohort", "trismus", "--json", str(answer)]) == 0
    said = capsys.readouterr().out
    assert "15 mm" in said and "all muscles" in said and TELLS in said
    assert [line for line in said.splitlines() if line.startswith("left : right")][0].endswith("not measured")
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert found["believed"] is True and found["openings_mm"] == [5.0, 10.0, 15.0, 20.0]
    low, middle, high = found["forces_N"][2]
    assert low < middle < high and found["told"]["all"] in (True, False) and not found["told"]["left : right"]


def test_a_log_that_creeps_is_not_believed(tmp_path, capsys):
    written(log_of(patient(), creep=0.3), tmp_path / "log.csv")
    answer = tmp_path / "answer.json"
    assert main(["identify", str(tmp_path / "log.csv"), "--cohort", "trismus", "--json", str(answer)]) == 3
    said = capsys.readouterr().out
    assert "NOT TO BE BELIEVED" in said and "creep" in said and TELLS not in said
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert found["believed"] is False and found["forces_N"] == [] and len(found["doubts"]) == 2


def test_an_earlier_log_gives_the_change(log, tmp_path, capsys):
    stiffer = patient()
    stiffer[::2] += 0.5
    written(log_of(stiffer, mm=20.0, seed=1), tmp_path / "before.csv")
    arguments = ["identify", str(log), "--before", str(tmp_path / "before.csv"), "--cohort", "trismus"]
    assert main([*arguments, "--json", str(tmp_path / "answer.json")]) == 0
    assert "force at 15 mm" in capsys.readouterr().out
    found = json.loads((tmp_path / "answer.json").read_text(encoding="utf-8"))
    assert found["change"]["force at 15 mm"][2] < 0.9 and len(found["before"]) == 1


@pytest.mark.parametrize(("option", "value"), [("page", "page.html"), ("knowledge", "imaged"), ("resample", "100")])
def test_options_of_six_forces_are_refused(log, tmp_path, capsys, option, value):
    assert main(["identify", str(log), f"--{option}", value]) == 2
    said = capsys.readouterr().err
    assert option in said and "with a log of force and opening; allowed: " in said and said.count("\n") == 1


def test_a_recording_has_no_earlier_log(tmp_path, capsys):
    path = tmp_path / "bench.csv"
    path.write_text("time_s,pitch_deg,force_x_N\n0,0,0\n0.01,0,0\n", encoding="utf-8")
    assert main(["identify", str(path), "--before", str(path)]) == 2
    assert "before" in capsys.readouterr().err
