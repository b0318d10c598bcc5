"""Outputs of ``python -m training`` belong to one process at a time."""

from pathlib import Path

import pytest

from jawenv.locks import alone
from training.cli import main


@pytest.mark.parametrize(
    ("command", "output"),
    [
        (["design", "--horizon-s", "1"], "found.yaml"),
        (["optimise", "--generations", "1", "--overwrite"], "found.yaml"),
        (["distill", "--rounds", "1"], "run"),
        (["train", "plain_ppo", "--steps", "256", "--overwrite"], "run"),
    ],
)
def test_an_output_in_use_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str], output: str
) -> None:
    path = tmp_path / output
    with alone(path):
        assert main([*command, "--output", str(path)]) == 2
    expected = f"error: {path}: in use by another process; wait for it, or name another output\n"
    assert capsys.readouterr().err == expected
    assert not list(tmp_path.iterdir()), "nothing was begun"


def test_a_run_in_use_is_neither_resumed_nor_exported_over(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    assert main(["train", str(tiny_config), "--output", str(run), "--steps", "256"]) == 0
    with alone(run):
        assert main(["train", "--resume", str(run), "--steps", "512"]) == 2
        assert "run: in use by another process" in capsys.readouterr().err
    curves = tmp_path / "curves.png"
    with alone(curves):
        assert main(["plot", str(run), "--output", str(curves)]) == 2
        assert "curves.png: in use by another process" in capsys.readouterr().err


def test_trials_of_two_studies_do_not_share_a_folder(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "tune"
    command = ["tune", str(tiny_config), "--trials", "1", "--storage", f"sqlite:///{tmp_path / 'study.db'}"]
    with alone(folder / "trial-0000"):
        assert main([*command, "--output", str(folder)]) == 2
    assert "trial-0000: in use by another process" in capsys.readouterr().err
