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
