"""No command runs code of a file that it is given, unless it is told to trust it."""

import sys
from pathlib import Path

import pytest

from eval.commands.app import main
from eval.comparison import results
from jawenv.playing.policies.card import CARD
from jawenv.playing.rollout import DEFAULT_ENV
from tests.eval.runs import make_it_run_code, save_checkpoint, save_run
from tests.eval.studies import study

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # the file that the pickle opens

STUDY = 'title: a\nentries: ["{agent}"]\npatients: 1\nseed: 1\nepisode_s: 1.0\n'


@pytest.mark.parametrize("command", ["compare", "calibrate", "patient", "play", "replay", "study"])
def test_commands_unpickle_nothing_without_trust(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = save_checkpoint(tmp_path / "got.zip")
    make_it_run_code(spec, tmp_path / "ran")
    if command == "study":
        spec = tmp_path / "a.yaml"
        spec.write_text(STUDY.format(agent=tmp_path / "got.zip"))
    option, output = {"play": ("--video", "out.webp"), "replay": ("--output", "out.yaml")}.get(
        command, ("--output", "out")
    )
    arguments = [command, str(spec), option, str(tmp_path / output)]
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert told.startswith("error: ") and "got.zip" in told and "--trust" in told
    assert told.count("\n") == 1 and not (tmp_path / "ran").exists()
    assert main([*arguments, "--trust"]) == 2  # what ran made no policy
    assert "damaged stable-baselines3 checkpoint" in capsys.readouterr().err and (tmp_path / "ran").exists()


@pytest.mark.parametrize("trust", [[], ["--trust"]])
def test_a_strangers_run_is_compared_and_runs_no_code(
    trust: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("eval.report.page.write", lambda study, ranking, path: path)
    run = save_run(tmp_path / "run")
    make_it_run_code(run / "checkpoints" / "step_1.zip", tmp_path / "ran")
    settings = ["--patients", "1", "--episode-s", "0.5", "--output", str(tmp_path / "out")]
    assert main(["compare", str(run), *settings, *trust]) == 0
    assert "results: " in capsys.readouterr().out and not (tmp_path / "ran").exists()


def test_an_environment_of_a_run_that_names_a_module_imports_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = save_run(tmp_path / "run")
    text = (run / CARD).read_text()
    assert DEFAULT_ENV in text
    (run / CARD).write_text(text.replace(DEFAULT_ENV, "antigravity:Jaw-v1"))
    assert main(["compare", str(run), "--output", str(tmp_path / "out")]) == 2
    assert "antigravity" not in sys.modules and "allowed: jawenv/Jaw" in capsys.readouterr().err


def test_a_comparisons_table_that_names_a_module_runs_no_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its films are left out, and the report is written."""
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "stranger.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n")
    made = study(patients=3)
    for entry in made.about["entries"]:
        entry["spec"] = "stranger:Agent"
    results.save(made, tmp_path / "got")
    assert main(["report", str(tmp_path / "got")]) == 0
    assert "is a module, which runs code" in capsys.readouterr().out and not (tmp_path / "ran").exists()
    assert (tmp_path / "got" / "report.html").exists()
    assert main(["report", str(tmp_path / "got"), "--trust"]) == 0 and (tmp_path / "ran").exists()
