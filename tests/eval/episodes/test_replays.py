"""The commands that make and compare replays."""

from functools import partial

import pandas as pd
import pytest

from agents.clairvoyant import Clairvoyant
from eval.commands.app import main
from jawenv.base.seeds import REPLAYS
from jawenv.playing.maneuvers import Maneuver

SHORT = ["--patients", "2", "--episode-s", "2"]


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """A planner of few candidates, and no report."""
    monkeypatch.setattr("agents.registry.PLANNERS", {"planned": partial(Clairvoyant, "planned", updates=2)})
    monkeypatch.setattr("eval.report.page.write", lambda study, ranking, path: path)


def test_a_replay_is_written_as_a_maneuver(tmp_path, capsys):
    path = tmp_path / "deep" / "replay.yaml"
    assert main(["replay", "planned", *SHORT, "--output", str(path)]) == 0
    maneuver = Maneuver.load(path)
    assert maneuver.name == "replay_of_planned" and f"seeds {REPLAYS.start} to {REPLAYS.start + 1}" in maneuver.source
    assert str(path) in capsys.readouterr().out


def test_a_comparison_with_replays_says_whether_an_entry_adapts(tmp_path, capsys):
    arguments = ["compare", "planned", "hold_still", *SHORT, "--control", "targets", "--with-replay"]
    assert main([*arguments, "--output", str(tmp_path)]) == 0
    written = capsys.readouterr().out
    assert "Trained and planned entries" in written
    patients = pd.read_parquet(tmp_path / "patients.parquet")
    assert list(dict.fromkeys(patients["entry"])) == [
        "planned",
        "replay of planned",
        "yoked replay of planned",
        "hold_still",
    ]
    assert patients["early_worst_sd"].isna().all()
    assert main([*arguments, "--output", str(tmp_path)]) == 0
    again = capsys.readouterr().out
    assert "averaging" not in again and "8 of 8 episodes kept from an earlier run" in again
    assert main(["report", str(tmp_path)]) == 0
    assert "Trained and planned entries" in capsys.readouterr().out


def test_what_has_no_replay_is_named(tmp_path, capsys):
    targets = [*SHORT, "--control", "targets", "--with-replay", "--output", str(tmp_path)]
    assert main(["compare", "hold_still", *targets]) == 2
    assert capsys.readouterr().err == "error: with-replay: no entry is trained or planned; allowed: at least one\n"
    assert main(["compare", "planned", *targets, "--seed", str(REPLAYS.start + 1)]) == 2
    assert "allowed with replays: none of the seeds 35000 to 35001" in capsys.readouterr().err
    assert main(["replay", "planned", *SHORT, "--output", str(tmp_path / "replay.json")]) == 2
    assert "allowed: a file that ends in .yaml" in capsys.readouterr().err
