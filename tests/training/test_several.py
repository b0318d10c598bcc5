"""Several seeds in one command."""

from pathlib import Path

import pytest

from training.cli import main
from training.run.evaluation_table import read_evaluations
from training.run.folder import RunFolder
from training.run.several import parse_seeds


@pytest.mark.parametrize(
    ("text", "seeds"), [("3", [3]), ("0-4", [0, 1, 2, 3, 4]), ("0,1,2", [0, 1, 2]), ("7, 1-2,2", [7, 1, 2])]
)
def test_seeds_are_read(text: str, seeds: list[int]) -> None:
    assert parse_seeds(text) == seeds


def test_finished_seeds_are_skipped_and_unfinished_ones_go_on(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stem = tmp_path / "study"
    command = ["train", str(tiny_config), "--output", str(stem)]
    assert main([*command, "--seeds", "1", "--steps", "512"]) == 0
    assert main([*command, "--seeds", "2", "--steps", "256"]) == 0
    capsys.readouterr()
    assert main([*command, "--seeds", "1-3", "--steps", "512"]) == 0
    output = capsys.readouterr().out
    assert output.count("nothing to do") == 1 and "seed 3, 3 of 3" in output
    runs = [RunFolder(tmp_path / f"study-seed{seed}") for seed in (1, 2, 3)]
    assert [run.open().seed for run in runs] == [1, 2, 3]
    assert [[row["steps"] for row in read_evaluations(run)] for run in runs] == [[0, 512], [0, 256, 512], [0, 512]]


def test_nothing_is_begun_if_one_folder_has_other_settings(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stem = tmp_path / "study"
    command = ["train", str(tiny_config), "--output", str(stem), "--steps", "256", "--seeds"]
    assert main([*command, "1"]) == 0
    tiny_config.write_text(tiny_config.read_text().replace("n_steps: 32", "n_steps: 16"))
    assert main([*command, "0-1"]) == 2
    assert "study-seed1 has other settings (ppo)" in capsys.readouterr().err
    assert not (tmp_path / "study-seed0").exists()
